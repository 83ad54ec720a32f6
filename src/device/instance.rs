//! The Vulkan loader, an instance, and what validation layers say.

use super::error::Context;
use super::{DeviceError, DeviceInfo, Messages, Result, Validation, lock, select};
use ash::vk;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The first validation layers that lock what they keep of a command buffer's labels before they forget it. Older ones do
/// so on a thread of their own while the same handle, used again, is labelled: memory is written after it was freed, and
/// now and then the process aborts (Vulkan-ValidationLayers issue 5172, mended by pull request 5312).
const LABELS_LOCKED: u32 = vk::make_api_version(0, 1, 3, 243);

/// The loader and an instance: enough to look at devices.
pub(super) struct Instance {
    _entry: ash::Entry,
    pub(super) raw: ash::Instance,
    debug: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Whether objects can be named, for validation messages and debuggers.
    pub(super) names: bool,
    /// Whether passes can be labelled too.
    pub(super) labels: bool,
    pub(super) messages: Messages,
}

/// All Vulkan devices, usable or not.
pub fn list() -> Result<Vec<DeviceInfo>> {
    Ok(Instance::new(Validation::Off)?.devices()?.into_iter().map(|d| d.1).collect())
}

impl Instance {
    /// With the validation layers that check what is said.
    pub(super) fn new(checks: Validation) -> Result<Self> {
        let validation = checks != Validation::Off;
        // SAFETY: loading libvulkan runs its initialisers, which are sound in any process state.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| DeviceError::NoLoader(e.to_string()))?;
        // SAFETY: the entry's functions are loaded.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.context("instance layers")?;
        let there = layers.iter().find(|l| l.layer_name_as_c_str() == Ok(VALIDATION));
        let checked_by = match there.filter(|_| validation) {
            None if validation => return Err(DeviceError::NoValidation),
            layer => layer.map(|l| l.spec_version),
        };
        // SAFETY: as above.
        let extensions =
            unsafe { entry.enumerate_instance_extension_properties(None) }.context("instance extensions")?;
        let has_debug =
            extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(ash::ext::debug_utils::NAME));

        let app =
            vk::ApplicationInfo::default().application_name(c"boxwood").api_version(vk::API_VERSION_1_2);
        let layer_names = if validation { vec![VALIDATION.as_ptr()] } else { vec![] };
        let mut names = vec![];
        if has_debug {
            names.push(ash::ext::debug_utils::NAME.as_ptr());
        }
        if validation {
            names.push(ash::ext::validation_features::NAME.as_ptr());
        }
        use vk::ValidationFeatureEnableEXT as Check;
        let mut enabled = vec![Check::SYNCHRONIZATION_VALIDATION];
        if checks == Validation::GpuAssisted {
            enabled.extend([Check::GPU_ASSISTED, Check::GPU_ASSISTED_RESERVE_BINDING_SLOT]);
        }
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut create = vk::InstanceCreateInfo::default()
            .application_info(&app)
            .enabled_layer_names(&layer_names)
            .enabled_extension_names(&names);
        if validation {
            create = create.push_next(&mut features);
        }
        // SAFETY: names and structs outlive the call.
        let raw = unsafe { entry.create_instance(&create, None) }.context("vkCreateInstance")?;
        let labels = has_debug && bear_labels(checked_by);
        let mut instance =
            Self { _entry: entry, raw, debug: None, names: has_debug, labels, messages: Messages::default() };
        if validation {
            let loader = ash::ext::debug_utils::Instance::new(&instance._entry, &instance.raw);
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::ERROR
                        | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
                )
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(on_message))
                .user_data(Arc::as_ptr(&instance.messages.0).cast_mut().cast());
            // SAFETY: `messages` lives in this Instance, which destroys the messenger before it goes.
            let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
                .context("vkCreateDebugUtilsMessengerEXT")?;
            instance.debug = Some((loader, messenger));
        }
        Ok(instance)
    }

    pub(super) fn devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>> {
        // SAFETY: the instance is alive.
        let all = unsafe { self.raw.enumerate_physical_devices() }.context("vkEnumeratePhysicalDevices")?;
        Ok(all.into_iter().enumerate().map(|(i, p)| (p, select::inspect(&self.raw, p, i))).collect())
    }

    /// Whether a device that has calibrated timestamps has them of its own clock.
    pub(super) fn tells_device_time(&self, physical: vk::PhysicalDevice) -> bool {
        let loader = ash::ext::calibrated_timestamps::Instance::new(&self._entry, &self.raw);
        // SAFETY: `physical` comes from this instance and has the extension.
        let domains = unsafe { loader.get_physical_device_calibrateable_time_domains(physical) };
        domains.is_ok_and(|domains| domains.contains(&vk::TimeDomainEXT::DEVICE))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((loader, messenger)) = &self.debug {
            // SAFETY: made by this loader, destroyed once.
            unsafe { loader.destroy_debug_utils_messenger(*messenger, None) };
        }
        // SAFETY: everything made from the instance is gone: Device holds it as its last field.
        unsafe { self.raw.destroy_instance(None) };
    }
}

/// Whether passes may be labelled under validation layers of version `checked_by`, if any.
fn bear_labels(checked_by: Option<u32>) -> bool {
    checked_by.is_none_or(|version| version >= LABELS_LOCKED)
}

/// # Safety
/// Called by the loader with a valid callback struct and the user data given at creation.
unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the loader passes a valid struct.
    let data = unsafe { &*data };
    // SAFETY: set at creation to a Mutex that outlives the messenger.
    let messages = unsafe { &*user.cast::<Mutex<Vec<String>>>() };
    if !data.p_message.is_null() {
        // SAFETY: a NUL-terminated string by the specification.
        let text = unsafe { CStr::from_ptr(data.p_message) }.to_string_lossy().into_owned();
        tracing::error!("{text}");
        lock(messages).push(text);
    }
    vk::FALSE
}

#[cfg(test)]
mod tests {
    use super::bear_labels;
    use ash::vk::make_api_version;

    #[test]
    fn labels_are_left_out_under_layers_that_do_not_bear_them() {
        // Debian 12's, the last before the mend, the first with it, and later ones.
        let borne = [(3, 239), (3, 242), (3, 243), (4, 309)]
            .map(|(minor, patch)| bear_labels(Some(make_api_version(0, 1, minor, patch))));
        assert_eq!(borne, [false, false, true, true]);
        assert!(bear_labels(None), "nothing keeps labels where nothing checks");
    }
}
