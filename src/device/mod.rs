//! Vulkan: devices, buffers, kernels, recorded passes and their times. Knows no trees.
//! The one room where `unsafe` is allowed: each block holds one call and says why it is sound.
#![allow(unsafe_code)]

mod acceleration;
mod buffer;
mod error;
mod events;
mod faults;
mod instance;
mod memory;
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
pub use instance::list;
pub use recorder::Recorder;
pub use select::{DeviceInfo, Feature, choose};
pub use shape::Shape;
pub use times::{Pass, Times, Timing};

use ash::vk;
use gpu_allocator::vulkan as ga;
use instance::Instance;
use std::collections::{BTreeMap, HashMap};
use std::ffi::{CStr, CString};
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

/// An open device. Shared by everything made from it; freed with the last of them.
pub struct Device {
    info: DeviceInfo,
    shape: Shape,
    /// Whether kernels use 64-bit integers and floats.
    wide: bool,
    raw: ash::Device,
    /// Where objects can be named and passes labelled.
    debug: Option<ash::ext::debug_utils::Device>,
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
        let debug = instance.names.then(|| ash::ext::debug_utils::Device::new(&instance.raw, &raw));
        let calibrated =
            calibrated.then(|| ash::ext::calibrated_timestamps::Device::new(&instance.raw, &raw));
        Ok(Arc::new(Self {
            shape: options.shape.clone().unwrap_or_else(|| Shape::of(&info)),
            info,
            wide,
            raw,
            debug,
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
        let (Some(debug), Ok(name)) = (&self.debug, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: a live object of this device. A name that the driver has no room for does no harm.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// What labels passes, where that does no harm.
    fn labels(&self) -> Option<&ash::ext::debug_utils::Device> {
        self.debug.as_ref().filter(|_| self.instance.labels)
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
