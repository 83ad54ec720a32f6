//! The driver's own acceleration structures (VK_KHR_acceleration_structure): one over triangles, and above it one with
//! that as its only instance, which ray queries start from. Not compacted, never updated.

use super::buffer::Allocated;
use super::error::{DeviceError, Result};
use super::{Buffer, Device, Recorder, lock};
use ash::{khr, vk};
use gpu_allocator::MemoryLocation;
use std::ffi::CStr;
use std::slice;
use std::sync::Arc;

/// What ray queries take: the last is wanted by the first.
pub(super) const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Bytes of an instance, and of its address's alignment.
const INSTANCE_BYTES: u64 = 64;
const INSTANCE_ALIGNMENT: u64 = 16;

/// What a device's builder can do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Triangles of a structure.
    pub(super) triangles: u64,
    /// Of scratch addresses, bytes.
    pub(super) scratch_alignment: u64,
}

/// The limits of a device that has [`EXTENSIONS`] and their features; `has` tells its extensions.
pub(super) fn limits(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    has: impl Fn(&CStr) -> bool,
) -> Option<Limits> {
    if !EXTENSIONS.into_iter().all(has) {
        return None;
    }
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut features =
        vk::PhysicalDeviceFeatures2::default().push_next(&mut structures).push_next(&mut queries);
    // SAFETY: `physical` comes from this instance and has the extensions of the chained structs.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    if structures.acceleration_structure == 0 || queries.ray_query == 0 {
        return None;
    }
    let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: as above.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    Some(Limits {
        triangles: limits.max_primitive_count,
        scratch_alignment: u64::from(limits.min_acceleration_structure_scratch_offset_alignment).max(1),
    })
}

/// Triangles for the driver's builder.
#[derive(Debug, Clone, Copy)]
pub struct Triangles<'b> {
    /// Nine floats a triangle, all of them finite where a triangle has a part in it.
    pub corners: &'b Buffer<f32>,
    /// Three corners a triangle, each a number of three floats; none: as they lie.
    pub indices: Option<&'b Buffer<u32>>,
    /// Triangles.
    pub count: u32,
}

/// A structure and its memory.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    memory: Allocated,
    device: Arc<Device>,
}

impl Drop for Structure {
    fn drop(&mut self) {
        // Before its memory: both go with the last recorder that may refer to them.
        lock(&self.device.dropped_structures).push(self.raw);
    }
}

/// The driver's structures over triangles, opaque: what a ray query meets is counted in the order in which they were
/// given.
pub struct Acceleration {
    over_triangles: Structure,
    over_instance: Structure,
}

impl Acceleration {
    /// Records their build; `triangles` are left as they are, and not needed after it.
    ///
    /// # Errors
    /// [`DeviceError::Lacking`] without ray queries, [`DeviceError::Limit`] for more triangles than there are or than the
    /// driver takes, not enough device memory.
    pub fn record(rec: &mut Recorder, triangles: &Triangles) -> Result<Self> {
        let device = rec.device().clone();
        let limits = device.ray_query_limits()?;
        let there = triangles.indices.map_or(triangles.corners.len() / 9, |indices| indices.len() / 3);
        let limit = (there as u64).min(limits.triangles).min((u32::MAX / 3).into());
        if u64::from(triangles.count) > limit {
            let (what, wanted) = ("triangles of an acceleration structure".into(), triangles.count.into());
            return Err(DeviceError::Limit { what, wanted, limit });
        }
        let geometry = [triangles.geometry()];
        let bottom = info(vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, &geometry);
        let bottom_sizes = device.sizes(&bottom, triangles.count)?;
        let over_triangles = device.structure("acceleration.triangles", &bottom, &bottom_sizes)?;

        let local = MemoryLocation::GpuOnly;
        let bytes = INSTANCE_BYTES + INSTANCE_ALIGNMENT;
        let instance = Allocated::new(&device, "acceleration.instance", bytes, local)?;
        let at = instance.address.next_multiple_of(INSTANCE_ALIGNMENT);
        let words = instance_of(device.address(&over_triangles)?);
        rec.update_bytes(&instance, at - instance.address, bytemuck::cast_slice(&words));
        let geometry = [instances(at)];
        let top = info(vk::AccelerationStructureTypeKHR::TOP_LEVEL, &geometry);
        let top_sizes = device.sizes(&top, 1)?;
        let over_instance = device.structure("acceleration.top", &top, &top_sizes)?;

        // One after the other, so in the same scratch.
        let bytes = bottom_sizes.build_scratch_size.max(top_sizes.build_scratch_size);
        let bytes = bytes + limits.scratch_alignment;
        let scratch = Allocated::new(&device, "acceleration.scratch", bytes, local)?;
        let scratch = vk::DeviceOrHostAddressKHR {
            device_address: scratch.address.next_multiple_of(limits.scratch_alignment),
        };
        let bottom = bottom.dst_acceleration_structure(over_triangles.raw).scratch_data(scratch);
        rec.build("acceleration/triangles", &bottom, triangles.count)?;
        let top = top.dst_acceleration_structure(over_instance.raw).scratch_data(scratch);
        rec.build("acceleration/instance", &top, 1)?;
        // What is dropped here lives as long as the recorder.
        Ok(Self { over_triangles, over_instance })
    }

    /// Where ray queries start: a kernel's `accelerationStructureEXT(address)`.
    ///
    /// # Errors
    /// [`DeviceError::Lacking`]: never, on the device that it was built on.
    pub fn address(&self) -> Result<[u32; 2]> {
        let address = self.over_instance.device.address(&self.over_instance)?;
        Ok([address as u32, (address >> 32) as u32])
    }

    /// Bytes of device memory that tracing needs.
    pub fn bytes(&self) -> u64 {
        self.over_triangles.memory.bytes + self.over_instance.memory.bytes
    }
}

impl std::fmt::Debug for Acceleration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Acceleration").field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}

impl Triangles<'_> {
    fn geometry(&self) -> vk::AccelerationStructureGeometryKHR<'static> {
        let address = |device_address| vk::DeviceOrHostAddressConstKHR { device_address };
        let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(address(self.corners.memory.address))
            .vertex_stride(12)
            .max_vertex((self.corners.len() / 3).saturating_sub(1) as u32);
        let triangles = match self.indices {
            None => triangles.index_type(vk::IndexType::NONE_KHR),
            Some(indices) => {
                triangles.index_type(vk::IndexType::UINT32).index_data(address(indices.memory.address))
            }
        };
        vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
            .flags(vk::GeometryFlagsKHR::OPAQUE)
    }
}

fn instances(device_address: u64) -> vk::AccelerationStructureGeometryKHR<'static> {
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address });
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances })
        .flags(vk::GeometryFlagsKHR::OPAQUE)
}

/// VkAccelerationStructureInstanceKHR: the identity, seen by every ray from both sides.
fn instance_of(structure: u64) -> [u32; 16] {
    let [zero, one] = [0f32, 1.0].map(f32::to_bits);
    let (every_ray, both_sides) = (0xff << 24, vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE);
    let mut words = [zero; 16];
    for row in 0..3 {
        words[5 * row] = one;
    }
    words[12] = every_ray;
    words[13] = both_sides.as_raw() << 24;
    words[14] = structure as u32;
    words[15] = (structure >> 32) as u32;
    words
}

fn info<'g>(
    ty: vk::AccelerationStructureTypeKHR,
    geometry: &'g [vk::AccelerationStructureGeometryKHR<'g>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'g> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(ty)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometry)
}

impl Device {
    /// Refuses to go on where the device has no ray queries.
    ///
    /// # Errors
    /// [`DeviceError::Lacking`].
    pub fn require_ray_query(&self) -> Result<()> {
        self.ray_query_limits().map(|_| ())
    }

    fn ray_query_limits(&self) -> Result<Limits> {
        self.info.ray_query.filter(|_| self.structures.is_some()).ok_or_else(|| self.no_ray_query())
    }

    fn structures(&self) -> Result<&khr::acceleration_structure::Device> {
        self.structures.as_ref().ok_or_else(|| self.no_ray_query())
    }

    fn no_ray_query(&self) -> DeviceError {
        DeviceError::Lacking { device: self.info.name.clone(), what: "VK_KHR_ray_query".into() }
    }

    fn sizes(
        &self,
        info: &vk::AccelerationStructureBuildGeometryInfoKHR,
        count: u32,
    ) -> Result<vk::AccelerationStructureBuildSizesInfoKHR<'static>> {
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let on = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: a complete info of one geometry, and one count for it.
        unsafe { self.structures()?.get_acceleration_structure_build_sizes(on, info, &[count], &mut sizes) };
        Ok(sizes)
    }

    fn structure(
        self: &Arc<Self>,
        name: &str,
        info: &vk::AccelerationStructureBuildGeometryInfoKHR,
        sizes: &vk::AccelerationStructureBuildSizesInfoKHR,
    ) -> Result<Structure> {
        let structures = self.structures()?;
        let (bytes, local) = (sizes.acceleration_structure_size, MemoryLocation::GpuOnly);
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let memory = Allocated::with_usage(self, name, bytes, local, usage)?;
        let create =
            vk::AccelerationStructureCreateInfoKHR::default().buffer(memory.raw).size(bytes).ty(info.ty);
        // SAFETY: a buffer of that usage, no smaller, which lives as long as the structure.
        let make = || unsafe { structures.create_acceleration_structure(&create, None) };
        let raw = self.taking(name, make)?;
        Ok(Structure { raw, memory, device: self.clone() })
    }

    fn address(&self, structure: &Structure) -> Result<u64> {
        let info =
            vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(structure.raw);
        // SAFETY: the structure is alive.
        Ok(unsafe { self.structures()?.get_acceleration_structure_device_address(&info) })
    }

    /// Destroys structures that were dropped. Only where no recorder is left.
    pub(super) fn bury_structures(&self) {
        let dropped: Vec<_> = lock(&self.dropped_structures).drain(..).collect();
        for raw in dropped {
            if let Some(structures) = &self.structures {
                // SAFETY: no recorder refers to it and no submit is pending; destroyed once.
                unsafe { structures.destroy_acceleration_structure(raw, None) };
            }
        }
    }
}

impl Recorder {
    /// Records one build as a pass. The recorder's own barriers know kernels and copies; those here join them with what
    /// the driver's builder reads and writes.
    fn build(
        &mut self,
        name: &'static str,
        info: &vk::AccelerationStructureBuildGeometryInfoKHR,
        count: u32,
    ) -> Result<()> {
        use vk::{AccessFlags as A, PipelineStageFlags as S};
        let (kernels, builder) = (S::COMPUTE_SHADER | S::TRANSFER, S::ACCELERATION_STRUCTURE_BUILD_KHR);
        let of_builder = A::ACCELERATION_STRUCTURE_READ_KHR | A::ACCELERATION_STRUCTURE_WRITE_KHR;
        // Triangles and instances are read as by a shader; structures and scratch, which may be used again, as such.
        self.join(
            (kernels | builder, A::SHADER_WRITE | A::TRANSFER_WRITE | A::ACCELERATION_STRUCTURE_WRITE_KHR),
            (builder, of_builder | A::SHADER_READ),
        );
        let range = vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count);
        let device = self.device().clone();
        // SAFETY: recording; structure, scratch and input are alive until the submit has finished, of the sizes that
        // were asked for, and nothing else touches them between the barriers.
        unsafe {
            device.structures()?.cmd_build_acceleration_structures(
                self.commands,
                slice::from_ref(info),
                &[slice::from_ref(&range)],
            );
        }
        let of_kernels = A::SHADER_READ | A::SHADER_WRITE | A::TRANSFER_READ | A::TRANSFER_WRITE;
        self.join(
            (builder, A::ACCELERATION_STRUCTURE_WRITE_KHR),
            (kernels | builder, of_builder | of_kernels),
        );
        self.after_drivers_pass(name);
        Ok(())
    }

    /// What the first stages did comes before what the second do.
    fn join(
        &mut self,
        before: (vk::PipelineStageFlags, vk::AccessFlags),
        after: (vk::PipelineStageFlags, vk::AccessFlags),
    ) {
        let barrier = [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
        // SAFETY: recording, outside a render pass; the stages are those of an enabled extension.
        unsafe {
            self.device().raw.cmd_pipeline_barrier(
                self.commands,
                before.0,
                after.0,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::instance_of;
    use ash::vk;

    #[test]
    fn an_instance_is_as_vulkan_has_it() {
        let wanted = vk::AccelerationStructureInstanceKHR {
            transform: vk::TransformMatrixKHR {
                matrix: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            },
            instance_custom_index_and_mask: vk::Packed24_8::new(0, 0xff),
            instance_shader_binding_table_record_offset_and_flags: vk::Packed24_8::new(
                0,
                vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw() as u8,
            ),
            acceleration_structure_reference: vk::AccelerationStructureReferenceKHR {
                device_handle: 0x0123_4567_89ab_cdef,
            },
        };
        // SAFETY: 64 bytes without padding, all of them initialised.
        let words: [u32; 16] = unsafe { std::mem::transmute(wanted) };
        assert_eq!(instance_of(0x0123_4567_89ab_cdef), words);
    }
}
