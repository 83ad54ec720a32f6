//! Compute pipelines, made at first use and kept: one a kernel and set of specialization constants.

use super::error::Result;
use super::{Device, lock};
use crate::abi::{Args, PUSH_BYTES};
use crate::kernels::Kernel;
use ash::vk;

/// What a pipeline is made for: kernel name, specialization constants.
pub(super) type Key = (&'static str, Vec<(u32, u32)>);

#[derive(Clone, Copy)]
pub(super) struct Pipeline {
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
}

impl Pipeline {
    pub(super) fn destroy(&self, device: &ash::Device) {
        // SAFETY: no submit that uses it is pending: the device is idle when pipelines go.
        unsafe { device.destroy_pipeline(self.raw, None) };
        // SAFETY: as above.
        unsafe { device.destroy_pipeline_layout(self.layout, None) };
    }
}

impl Device {
    /// The pipeline for `kernel` with `constants` (id, value), whose id 0 is the workgroup size.
    pub(super) fn pipeline<A: Args>(&self, kernel: &Kernel<A>, constants: &[(u32, u32)]) -> Result<Pipeline> {
        let key: Key = (kernel.name, constants.to_vec());
        if let Some(p) = lock(&self.pipelines).get(&key) {
            return Ok(*p);
        }
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(PUSH_BYTES as u32)];
        let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&push);
        // SAFETY: the info outlives the call.
        let layout = self.taking(kernel.name, || unsafe { self.raw.create_pipeline_layout(&info, None) })?;
        let raw = self.with_layout(kernel, constants, layout).inspect_err(|_| {
            // SAFETY: nothing was made of it.
            unsafe { self.raw.destroy_pipeline_layout(layout, None) };
        })?;
        self.name(raw, kernel.name);
        let pipeline = Pipeline { raw, layout };
        lock(&self.pipelines).insert(key, pipeline);
        Ok(pipeline)
    }

    fn with_layout<A: Args>(
        &self,
        kernel: &Kernel<A>,
        constants: &[(u32, u32)],
        layout: vk::PipelineLayout,
    ) -> Result<vk::Pipeline> {
        let bytes = kernel.spirv[usize::from(self.wide)];
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: SPIR-V that shaderc made and the build checked.
        let module = self.taking(kernel.name, || unsafe { self.raw.create_shader_module(&info, None) })?;
        let entries: Vec<_> = (0..constants.len())
            .map(|i| {
                vk::SpecializationMapEntry::default().constant_id(constants[i].0).offset(4 * i as u32).size(4)
            })
            .collect();
        let values: Vec<u32> = constants.iter().map(|c| c.1).collect();
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&values));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main")
            .specialization_info(&specialization);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
        // SAFETY: module and layout are alive; the constants are all 32-bit, as the kernels declare them.
        let make = || unsafe { self.raw.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        let made = self.taking(kernel.name, || make().map_err(|e| e.1));
        // SAFETY: no longer needed once the pipeline is made.
        unsafe { self.raw.destroy_shader_module(module, None) };
        Ok(made?[0])
    }
}
