//! Vulkan: devices, buffers, kernels, recorded passes and their times. Knows no trees.
//! The one room where `unsafe` is allowed: each block holds one call and says why it is sound.
#![allow(unsafe_code)]

mod acceleration;
mod buffer;
mod error;
mod events;
mod faults;
mod pipeline;
mod recorder;
mod select;
mod shape;
mod times;

pub use acceleration::{Acceleration, Triangles};
pub use buffer::Buffer;
pub use error::{DeviceError, Result};
pub use events::{Event, HostWork, Submit, Traffic, Work};
pub use faults::Faults;
pub use recorder::Recorder;
pub use select::{DeviceInfo, Feature, choose};
pub use shape::Shape;
pub use times::{Pass, Times, Timing};

use ash::vk;
use error::Context;
use gpu_allocator::vulkan as ga;
use std::collections::{BTreeMap, HashMap};
use std::ffi::{CStr, CString, c_void};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What the validation layers check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Validation {
    /// Nothing.
    #[default]
    Off,
    /// Calls, and synchronization.
    Core,
    /// Also every access that a kernel makes: slow, a hundredfold at a kernel's first use on lavapipe.
    GpuAssisted,
}

/// How to open a device.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Number or part of a name; none: the best.
    pub device: Option<String>,
    /// Validation layers; messages gather in [`Device::messages`].
    pub validation: Validation,
    /// Use no 64-bit integers and floats, even where the device has them: for tests.
    pub narrow: bool,
    /// Use no ray queries, even where the device has them: for tests.
    pub without_ray_query: bool,
    /// Kernel shapes; none: those that suit the device. Results don't depend on them, which tests check by this.
    pub shape: Option<Shape>,
    /// What fails: for tests.
    pub faults: Faults,
}

impl Options {
    /// The best device; `BOXWOOD_VALIDATION=1` turns the validation layers on, `BOXWOOD_VALIDATION=gpu` also their
    /// checks on the device.
    pub fn from_env() -> Self {
        let validation = match std::env::var("BOXWOOD_VALIDATION").as_deref() {
            Ok("gpu") => Validation::GpuAssisted,
            Err(_) | Ok("" | "0") => Validation::Off,
            Ok(_) => Validation::Core,
        };
        Self { validation, ..Self::default() }
    }
}

/// The loader and an instance: enough to look at devices.
struct Instance {
    _entry: ash::Entry,
    raw: ash::Instance,
    debug: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Whether passes can be labelled, for validation messages and debuggers.
    labels: bool,
    messages: Messages,
}

/// An open device. Shared by everything made from it; freed with the last of them.
pub struct Device {
    info: DeviceInfo,
    shape: Shape,
    /// Whether kernels use 64-bit integers and floats.
    wide: bool,
    raw: ash::Device,
    labels: Option<ash::ext::debug_utils::Device>,
    /// Where the device tells its clock's time.
    calibrated: Option<ash::ext::calibrated_timestamps::Device>,
    /// Where there are ray queries.
    structures: Option<ash::khr::acceleration_structure::Device>,
    physical: vk::PhysicalDevice,
    queue: Mutex<vk::Queue>,
    allocator: ManuallyDrop<Mutex<ga::Allocator>>,
    pipelines: Mutex<HashMap<pipeline::Key, pipeline::Pipeline>>,
    /// Recorders that may still submit work on any buffer.
    recorders: AtomicUsize,
    /// Buffers dropped while there were such recorders: spare with the last of them.
    dropped: Mutex<Vec<buffer::Memory>>,
    /// Likewise, the driver's acceleration structures.
    dropped_structures: Mutex<Vec<vk::AccelerationStructureKHR>>,
    /// Buffers to use again: fresh memory costs page faults at each build.
    spare: Mutex<Vec<buffer::Memory>>,
    /// Bytes of all live buffers, and the most there were since [`Device::track_memory`].
    in_use: AtomicU64,
    peak: AtomicU64,
    /// Bytes of each buffer, spare ones too, by address.
    buffers: Mutex<BTreeMap<u64, u64>>,
    /// Whether a submit has found the device lost: it stays so.
    lost: AtomicBool,
    due: faults::Due,
    instance: Instance,
}

/// What the validation layers say of a device, to its end and beyond.
#[derive(Debug, Clone, Default)]
pub struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    /// All so far.
    pub fn all(&self) -> Vec<String> {
        lock(&self.0).clone()
    }
}

/// A lock whose data stays usable after a panic elsewhere.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// All Vulkan devices, usable or not.
pub fn list() -> Result<Vec<DeviceInfo>> {
    Ok(Instance::new(Validation::Off)?.devices()?.into_iter().map(|d| d.1).collect())
}

impl Instance {
    fn new(checks: Validation) -> Result<Self> {
        let validation = checks != Validation::Off;
        // SAFETY: loading libvulkan runs its initialisers, which are sound in any process state.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| DeviceError::NoLoader(e.to_string()))?;
        // SAFETY: the entry's functions are loaded.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.context("instance layers")?;
        let there = layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION));
        if validation && !there {
            return Err(DeviceError::NoValidation);
        }
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
        let mut instance =
            Self { _entry: entry, raw, debug: None, labels: has_debug, messages: Messages::default() };
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

    fn devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>> {
        // SAFETY: the instance is alive.
        let all = unsafe { self.raw.enumerate_physical_devices() }.context("vkEnumeratePhysicalDevices")?;
        Ok(all.into_iter().enumerate().map(|(i, p)| (p, select::inspect(&self.raw, p, i))).collect())
    }

    /// Whether a device that has calibrated timestamps has them of its own clock.
    fn tells_device_time(&self, physical: vk::PhysicalDevice) -> bool {
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

impl Device {
    /// Opens a device.
    ///
    /// # Errors
    /// No loader, no usable device, none of the wanted name, validation layers missing, or a failed Vulkan call.
    pub fn open(options: &Options) -> Result<Arc<Self>> {
        let instance = Instance::new(options.validation)?;
        let mut all = instance.devices()?;
        let infos: Vec<DeviceInfo> = all.iter().map(|d| d.1.clone()).collect();
        let chosen = select::choose(&infos, options.device.as_deref())?;
        let (physical, info) = all.swap_remove(chosen);
        if let Some(warning) = &info.warning {
            tracing::warn!("{}: {warning}", info.name);
        }

        let wide = info.has_wide && !options.narrow;
        let core = vk::PhysicalDeviceFeatures::default()
            .shader_int64(wide)
            .shader_float64(wide)
            .pipeline_statistics_query(info.has_statistics);
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default()
            .buffer_device_address(true)
            .vulkan_memory_model(true)
            // The scope of atomics in kernels that hand nothing over: with the model it must be asked for.
            .vulkan_memory_model_device_scope(true)
            .scalar_block_layout(true);
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(info.queue_family)
            .queue_priorities(&[1.0])];
        let mut extensions = vec![];
        if info.has_memory_budget {
            extensions.push(vk::EXT_MEMORY_BUDGET_NAME.as_ptr());
        }
        let calibrated = info.has_calibrated_timestamps && instance.tells_device_time(physical);
        if calibrated {
            extensions.push(vk::EXT_CALIBRATED_TIMESTAMPS_NAME.as_ptr());
        }
        let ray_query = info.ray_query.is_some() && !options.without_ray_query;
        let mut structures =
            vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
        let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        if ray_query {
            extensions.extend(acceleration::EXTENSIONS.map(CStr::as_ptr));
        }
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&core)
            .push_next(&mut v12);
        if ray_query {
            create = create.push_next(&mut structures).push_next(&mut queries);
        }
        let due = faults::Due::new(options.faults);
        // SAFETY: the features and extensions asked for were found present by `inspect`.
        let make = || unsafe { instance.raw.create_device(physical, &create, None) };
        let raw = due.allocation().and_then(|()| make()).map_err(|result| match result {
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => DeviceError::Full {
                what: "vkCreateDevice".into(),
                available: info.memory_free.unwrap_or(info.memory) >> 20,
                device: info.name.clone(),
            },
            result => DeviceError::Vulkan { call: "vkCreateDevice".into(), result },
        })?;
        // SAFETY: one queue of this family was asked for.
        let queue = unsafe { raw.get_device_queue(info.queue_family, 0) };
        let allocator = ga::Allocator::new(&ga::AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: true,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|source| {
            // SAFETY: nothing was made from it yet.
            unsafe { raw.destroy_device(None) };
            DeviceError::Allocation { what: "the allocator".into(), bytes: 0, source }
        })?;
        let structures =
            ray_query.then(|| ash::khr::acceleration_structure::Device::new(&instance.raw, &raw));
        let labels = instance.labels.then(|| ash::ext::debug_utils::Device::new(&instance.raw, &raw));
        let calibrated =
            calibrated.then(|| ash::ext::calibrated_timestamps::Device::new(&instance.raw, &raw));
        Ok(Arc::new(Self {
            shape: options.shape.clone().unwrap_or_else(|| Shape::of(&info)),
            info,
            wide,
            raw,
            labels,
            calibrated,
            structures,
            physical,
            queue: Mutex::new(queue),
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            pipelines: Mutex::default(),
            recorders: AtomicUsize::new(0),
            dropped: Mutex::default(),
            dropped_structures: Mutex::default(),
            spare: Mutex::default(),
            in_use: AtomicU64::new(0),
            peak: AtomicU64::new(0),
            buffers: Mutex::default(),
            lost: AtomicBool::new(false),
            due,
            instance,
        }))
    }

    /// What is known of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Whether kernels use 64-bit integers and floats.
    pub fn is_wide(&self) -> bool {
        self.wide
    }

    /// Kernel shapes that suit the device. Results never depend on them.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// What the validation layers have said so far; empty without them.
    pub fn messages(&self) -> Vec<String> {
        self.instance.messages.all()
    }

    /// Likewise, and what they say while the device is freed: of what was not freed before it.
    pub fn all_messages(&self) -> Messages {
        self.instance.messages.clone()
    }

    /// Gives an object the name that validation messages and debuggers show.
    fn name(&self, object: impl vk::Handle, name: &str) {
        let (Some(labels), Ok(name)) = (&self.labels, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: a live object of this device. A name that the driver has no room for does no harm.
        let _ = unsafe { labels.set_debug_utils_object_name(&info) };
    }

    /// Takes a buffer that is no longer needed; spare as soon as no recorder can refer to it.
    fn discard(&self, memory: buffer::Memory) {
        lock(&self.dropped).push(memory);
        if self.recorders.load(Ordering::SeqCst) == 0 {
            self.bury();
        }
    }

    /// Makes dropped buffers spare. Only where no recorder is left.
    fn bury(&self) {
        self.bury_structures();
        let dropped: Vec<_> = lock(&self.dropped).drain(..).collect();
        self.in_use.fetch_sub(dropped.iter().map(|m| m.bytes).sum(), Ordering::Relaxed);
        let mut spare = lock(&self.spare);
        spare.extend(dropped);
        // The oldest go first.
        let mut excess = spare.iter().map(|m| m.bytes).sum::<u64>().saturating_sub(self.info.memory / 8);
        while excess > 0 && !spare.is_empty() {
            let oldest = spare.remove(0);
            excess = excess.saturating_sub(oldest.bytes);
            self.free(oldest);
        }
    }

    /// A spare buffer of just this size, kind of memory and usage.
    fn take_spare(
        &self,
        bytes: u64,
        location: gpu_allocator::MemoryLocation,
        usage: vk::BufferUsageFlags,
    ) -> Option<buffer::Memory> {
        let mut spare = lock(&self.spare);
        let at = spare.iter().rposition(|m| (m.bytes, m.location, m.usage) == (bytes, location, usage))?;
        Some(spare.remove(at))
    }

    /// Gives all spare buffers back to the driver.
    fn free_spare(&self) {
        let spare: Vec<_> = lock(&self.spare).drain(..).collect();
        spare.into_iter().for_each(|m| self.free(m));
    }

    fn free(&self, memory: buffer::Memory) {
        lock(&self.buffers).remove(&memory.address);
        if let Some(allocation) = memory.allocation {
            // The allocator only refuses what it did not allocate.
            let _ = lock(&self.allocator).free(allocation);
        }
        // SAFETY: no recorder refers to it and no submit is pending; destroyed once.
        unsafe { self.raw.destroy_buffer(memory.raw, None) };
    }

    /// Memory of all live buffers, bytes.
    pub fn memory_in_use(&self) -> u64 {
        self.in_use.load(Ordering::Relaxed)
    }

    /// Starts watching for the most memory in use; returns what is in use now, bytes.
    pub fn track_memory(&self) -> u64 {
        let now = self.memory_in_use();
        self.peak.store(now, Ordering::Relaxed);
        now
    }

    /// The most memory in use since [`Device::track_memory`], bytes.
    pub fn peak_memory(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    /// Device-local memory free for this process, bytes: the driver's budget, else the whole heap.
    pub fn memory_free(&self) -> u64 {
        let driver = select::inspect(&self.instance.raw, self.physical, self.info.index);
        let spare: u64 = lock(&self.spare).iter().map(|m| m.bytes).sum();
        self.within_budget(driver.memory_free.unwrap_or(self.info.memory)) + spare
    }

    /// Refuses work that the device's memory can't hold.
    ///
    /// # Errors
    /// [`DeviceError::Memory`], with what was needed and what there is.
    pub fn require_memory(&self, what: &str, bytes: u64) -> Result<()> {
        let free = self.memory_free();
        if bytes <= free {
            return Ok(());
        }
        Err(DeviceError::Memory {
            what: what.into(),
            needed: bytes >> 20,
            available: free >> 20,
            device: self.info.name.clone(),
        })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: no other thread has the device: this is the last reference.
        let _ = unsafe { self.raw.device_wait_idle() };
        for pipeline in lock(&self.pipelines).values() {
            pipeline.destroy(&self.raw);
        }
        self.free_spare();
        // SAFETY: dropped once, here, before the device that it allocates from.
        unsafe { ManuallyDrop::drop(&mut self.allocator) };
        // SAFETY: everything made from the device is gone.
        unsafe { self.raw.destroy_device(None) };
    }
}

impl std::fmt::Debug for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Device").field("name", &self.info.name).finish_non_exhaustive()
    }
}
