//! Which devices there are, what each offers, and which one to use: a real GPU before a software one.

use super::acceleration::{self, Limits};
use ash::vk;
use std::ffi::CStr;

/// A feature boxwood asks a device for.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Feature {
    /// Vulkan's name.
    pub name: &'static str,
    /// Without it the device can't be used.
    pub required: bool,
    /// Whether the device has it.
    pub present: bool,
    /// What it is for.
    pub purpose: &'static str,
}

/// What is known of one physical device.
#[derive(Debug, Clone, serde::Serialize)]
pub struct DeviceInfo {
    /// Place in the driver's list.
    pub index: usize,
    /// Name.
    pub name: String,
    /// Kind: discrete GPU, integrated GPU, virtual GPU, CPU, other.
    pub kind: &'static str,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version, `1.3.250`.
    pub vulkan: String,
    /// Invocations a subgroup.
    pub subgroup_size: u32,
    /// Device-local memory, bytes.
    pub memory: u64,
    /// Device-local memory free for this process, bytes, where the driver tells.
    pub memory_free: Option<u64>,
    /// Largest storage-buffer binding, bytes.
    pub max_storage_buffer_range: u64,
    /// Largest workgroup, invocations.
    pub max_workgroup: u32,
    /// Nanoseconds a timestamp tick; 0: no timestamps.
    pub timestamp_period: f32,
    /// Valid bits of a timestamp.
    pub timestamp_bits: u32,
    /// Required and optional features.
    pub features: Vec<Feature>,
    /// Why it can't be used; empty if it can.
    pub refused: Vec<String>,
    /// A remark, such as a driver known to compute wrong results.
    pub warning: Option<String>,
    #[serde(skip)]
    pub(super) queue_family: u32,
    #[serde(skip)]
    pub(super) has_memory_budget: bool,
    #[serde(skip)]
    pub(super) has_wide: bool,
    #[serde(skip)]
    pub(super) has_statistics: bool,
    #[serde(skip)]
    pub(super) has_calibrated_timestamps: bool,
    #[serde(skip)]
    pub(super) ray_query: Option<Limits>,
}

impl DeviceInfo {
    /// Whether this is a software driver.
    pub fn is_cpu(&self) -> bool {
        self.kind == "CPU"
    }
    /// Whether boxwood can use it.
    pub fn usable(&self) -> bool {
        self.refused.is_empty()
    }
    fn rank(&self) -> u32 {
        match self.kind {
            "discrete GPU" => 0,
            "integrated GPU" => 1,
            "virtual GPU" => 2,
            "other" => 3,
            _ => 4,
        }
    }
}

fn text(raw: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = raw.iter().map(|c| *c as u8).take_while(|b| *b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Looks at one physical device.
pub(super) fn inspect(instance: &ash::Instance, physical: vk::PhysicalDevice, index: usize) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties =
        vk::PhysicalDeviceProperties2::default().push_next(&mut driver).push_next(&mut subgroup);
    // SAFETY: `physical` comes from this instance; the chain holds structs of Vulkan 1.1 and 1.2.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let p = properties.properties;
    // SAFETY: `physical` comes from this instance.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let recent = p.api_version >= vk::API_VERSION_1_2;

    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default();
    if recent {
        features = features.push_next(&mut v12);
    }
    // SAFETY: as above; the Vulkan 1.2 struct is chained only where the device is of that version.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    let f = features.features;
    let ray_query = if recent { acceleration::limits(instance, physical, has) } else { None };
    let operations = subgroup.supported_operations;
    let in_compute = subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
    let ops = |o: vk::SubgroupFeatureFlags| in_compute && operations.contains(o);
    use vk::SubgroupFeatureFlags as S;
    let feature = |name, required, present, purpose| Feature { name, required, present, purpose };
    let (required, optional) = (true, false);
    let table = vec![
        feature("Vulkan 1.2", required, recent, "the version the kernels are compiled for"),
        feature(
            "bufferDeviceAddress",
            required,
            v12.buffer_device_address != 0,
            "how kernels reach buffers of any size",
        ),
        feature(
            "scalarBlockLayout",
            required,
            v12.scalar_block_layout != 0,
            "structs laid out as on the host",
        ),
        feature(
            "vulkanMemoryModel, vulkanMemoryModelDeviceScope",
            required,
            v12.vulkan_memory_model != 0 && v12.vulkan_memory_model_device_scope != 0,
            "values handed from one workgroup to another, by its rules; Vulkan 1.3 has both",
        ),
        feature(
            "subgroup basic, vote, arithmetic, ballot",
            required,
            ops(S::BASIC | S::VOTE | S::ARITHMETIC | S::BALLOT),
            "reductions, packets",
        ),
        feature("timestamps", optional, p.limits.timestamp_period > 0.0, "times by kernel; else wall time"),
        feature(
            "VK_EXT_calibrated_timestamps",
            optional,
            has(vk::EXT_CALIBRATED_TIMESTAMPS_NAME),
            "passes on the host's clock, in profiles",
        ),
        feature(
            "pipelineStatisticsQuery",
            optional,
            f.pipeline_statistics_query != 0,
            "invocations by kernel, in profiles",
        ),
        feature(
            "VK_EXT_memory_budget",
            optional,
            has(vk::EXT_MEMORY_BUDGET_NAME),
            "free memory, before a build",
        ),
        feature("shaderInt64", optional, f.shader_int64 != 0, "loads of two words at a time"),
        feature(
            "shaderFloat64",
            optional,
            f.shader_float64 != 0,
            "rays at edges, decided in doubles; else by exact integers",
        ),
        feature(
            "VK_KHR_ray_query",
            optional,
            ray_query.is_some(),
            "bench --against ray-query: the device's own structure (VK_KHR_acceleration_structure) and its traversal",
        ),
        feature(
            "VK_EXT_subgroup_size_control",
            optional,
            has(vk::EXT_SUBGROUP_SIZE_CONTROL_NAME),
            "not used: results hold for any size",
        ),
    ];
    let mut refused: Vec<String> =
        table.iter().filter(|f| f.required && !f.present).map(|f| format!("no {}", f.name)).collect();

    // SAFETY: `physical` comes from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    // A queue for compute alone, where there is one, leaves the display's queue free.
    let compute = |without: vk::QueueFlags| {
        families.iter().position(|q| {
            q.queue_flags.contains(vk::QueueFlags::COMPUTE) && !q.queue_flags.intersects(without)
        })
    };
    let family = compute(vk::QueueFlags::GRAPHICS).or_else(|| compute(vk::QueueFlags::empty()));
    if family.is_none() {
        refused.push("no compute queue".into());
    }
    let family = family.unwrap_or(0);

    let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
    let has_memory_budget = has(vk::EXT_MEMORY_BUDGET_NAME);
    let mut memory = vk::PhysicalDeviceMemoryProperties2::default();
    if has_memory_budget {
        memory = memory.push_next(&mut budget);
    }
    // SAFETY: as above; the budget struct is chained only where the extension is there.
    unsafe { instance.get_physical_device_memory_properties2(physical, &mut memory) };
    let m = memory.memory_properties;
    let local: Vec<usize> = (0..m.memory_heap_count as usize)
        .filter(|i| m.memory_heaps[*i].flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
        .collect();
    let free = || local.iter().map(|i| budget.heap_budget[*i].saturating_sub(budget.heap_usage[*i])).sum();

    let driver_name = text(&driver.driver_name);
    let driver_info = text(&driver.driver_info);
    let warning = (driver.driver_id == vk::DriverId::MESA_LLVMPIPE && old_mesa(&driver_info)).then(|| {
        "lavapipe before Mesa 24.1 computes wrong results: run `make setup` for a newer one".to_owned()
    });
    DeviceInfo {
        index,
        name: text(&p.device_name),
        kind: match p.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete GPU",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated GPU",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual GPU",
            vk::PhysicalDeviceType::CPU => "CPU",
            _ => "other",
        },
        driver: format!("{driver_name} {driver_info}"),
        vulkan: format!(
            "{}.{}.{}",
            vk::api_version_major(p.api_version),
            vk::api_version_minor(p.api_version),
            vk::api_version_patch(p.api_version)
        ),
        subgroup_size: subgroup.subgroup_size,
        memory: local.iter().map(|i| m.memory_heaps[*i].size).sum(),
        memory_free: has_memory_budget.then(free),
        max_storage_buffer_range: p.limits.max_storage_buffer_range.into(),
        max_workgroup: p
            .limits
            .max_compute_work_group_invocations
            .min(p.limits.max_compute_work_group_size[0]),
        timestamp_period: p.limits.timestamp_period,
        timestamp_bits: families.get(family).map_or(0, |q| q.timestamp_valid_bits),
        features: table,
        refused,
        warning,
        queue_family: family as u32,
        has_memory_budget,
        has_wide: f.shader_int64 != 0 && f.shader_float64 != 0,
        has_statistics: f.pipeline_statistics_query != 0,
        has_calibrated_timestamps: has(vk::EXT_CALIBRATED_TIMESTAMPS_NAME),
        ray_query,
    }
}

/// Whether `Mesa 22.3.6…` is older than 24.1.
fn old_mesa(info: &str) -> bool {
    let Some(version) = info.split("Mesa ").nth(1) else { return false };
    let mut parts = version.split(|c: char| !c.is_ascii_digit()).map(|p| p.parse::<u32>().unwrap_or(0));
    (parts.next().unwrap_or(0), parts.next().unwrap_or(0)) < (24, 1)
}

/// The device that `wanted` names by number or part of its name, or the best: a real GPU before a software one.
/// Returns its place in `all`.
///
/// # Errors
/// No usable device, or none of that number or name.
pub fn choose(all: &[DeviceInfo], wanted: Option<&str>) -> super::Result<usize> {
    use super::DeviceError;
    let usable = || all.iter().filter(|d| d.usable());
    let found = match wanted {
        Some(w) => match w.parse::<usize>() {
            Ok(n) => usable().find(|d| d.index == n),
            Err(_) => usable().find(|d| d.name.to_lowercase().contains(&w.to_lowercase())),
        },
        None => usable().min_by_key(|d| (d.rank(), d.index)),
    };
    match (found, wanted) {
        (Some(d), _) => Ok(d.index),
        (None, Some(w)) => Err(DeviceError::NoSuchDevice {
            wanted: w.into(),
            there: usable().map(|d| format!("{} {}", d.index, d.name)).collect::<Vec<_>>().join(", "),
        }),
        (None, None) => Err(DeviceError::NoDevice {
            tried: if all.is_empty() {
                "the loader found none".into()
            } else {
                let tried = all.iter().map(|d| format!("{}: {}", d.name, d.refused.join(", ")));
                tried.collect::<Vec<_>>().join("; ")
            },
        }),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn old_lavapipe_is_known_by_its_version() {
        assert!(super::old_mesa("Mesa 22.3.6 (LLVM 15.0.6)"));
        assert!(!super::old_mesa("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)"));
        assert!(!super::old_mesa("560.35.03"));
    }
}
