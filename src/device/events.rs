//! What a submit did, pass by pass: where each lies on the host's clock, which buffers its arguments point to, how many
//! invocations the device counted.
//!
//! **Time.** A stamp is a tick of the device's clock. Where VK_EXT_calibrated_timestamps tells that clock's time, asked
//! between two looks at the host's, ticks are times of the host, give or take half of what lies between the looks;
//! elsewhere the first pass is taken to begin with the submit. Either way a submit's passes lie between it and its fence.

use super::error::{Context, Result};
use super::{Device, lock};
use crate::abi::{Args, SPEC_WG};
use ash::vk;
use std::time::{Duration, Instant};

/// Workgroup size of a kernel that is given none: the prelude's.
const WORKGROUP: u32 = 64;

/// A submit, as [`super::Timing::Passes`] sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Submit {
    /// When the device was given it.
    pub at: Instant,
    /// Until its fence, ms.
    pub wall_ms: f64,
    /// When the device began.
    pub device_at: Instant,
    /// Between the outer stamps, which hold all passes and nothing of the host, ms.
    pub device_ms: f64,
    /// How far `device_at` may be off, ms; none: unknown, for the device doesn't tell its clock's time.
    pub unsure_ms: Option<f64>,
    /// Its passes in order, transfers among them.
    pub events: Vec<Event>,
}

/// A pass.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The kernel's name; `fill`, `update` or `copy`.
    pub name: &'static str,
    /// When it began.
    pub at: Instant,
    /// From the stamp of the pass before to its own, ms.
    pub ms: f64,
    /// What was asked for.
    pub work: Work,
    /// What it may move.
    pub traffic: Traffic,
    /// Invocations that the device counted; none without [`super::Timing::Statistics`], or where it can't.
    pub invocations: Option<u64>,
}

/// Work on the host, in a kernel's stead.
#[derive(Debug, Clone, PartialEq)]
pub struct HostWork {
    /// Its name.
    pub name: &'static str,
    /// When it began.
    pub at: Instant,
    /// Wall time, ms.
    pub ms: f64,
}

/// What was asked of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// A dispatch.
    Groups {
        /// Workgroups, those that round a grid up among them.
        groups: u64,
        /// Invocations each.
        size: u32,
    },
    /// A dispatch of as many workgroups as a kernel before it found.
    Indirect {
        /// Invocations each.
        size: u32,
    },
    /// A fill, an update or a copy.
    Transfer,
    /// What only the driver knows: the build of a structure of its own.
    Driver,
}

impl Work {
    /// Whether it is a kernel's.
    pub(super) fn is_dispatch(self) -> bool {
        matches!(self, Self::Groups { .. } | Self::Indirect { .. })
    }

    pub(super) fn groups([x, y]: [u32; 2], constants: &[(u32, u32)]) -> Self {
        Self::Groups { groups: u64::from(x) * u64::from(y), size: workgroup(constants) }
    }

    pub(super) fn indirect(constants: &[(u32, u32)]) -> Self {
        Self::Indirect { size: workgroup(constants) }
    }

    /// Invocations, where the host knows them.
    pub fn invocations(self) -> Option<u64> {
        match self {
            Self::Groups { groups, size } => Some(groups * u64::from(size)),
            Self::Indirect { .. } | Self::Transfer | Self::Driver => None,
        }
    }
}

fn workgroup(constants: &[(u32, u32)]) -> u32 {
    constants.iter().find(|c| c.0 == SPEC_WG).map_or(WORKGROUP, |c| c.1)
}

/// Bytes of buffers that a pass can reach: of a kernel all that its arguments point to, each buffer once, read through
/// `Ptr`, written through `PtrMut`, both through `PtrShared`; of a transfer just what it moves. A kernel that goes
/// through part of a buffer moves less, one that comes back to what caches have lost moves more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Read.
    pub read: u64,
    /// Written.
    pub written: u64,
}

impl Traffic {
    /// Both ways.
    pub fn bytes(self) -> u64 {
        self.read + self.written
    }

    pub(super) fn of<A: Args>(device: &Device, args: &A) -> Self {
        let bytes = bytemuck::bytes_of(args);
        let (mut read, mut written) = (vec![], vec![]);
        for member in A::STRUCT.members {
            let ty: String = member.ty.chars().filter(|c| !c.is_whitespace()).collect();
            let (reads, writes) = match ty.split('<').next() {
                Some("Ptr") => (true, false),
                Some("PtrMut") => (false, true),
                Some("PtrShared") => (true, true),
                _ => continue,
            };
            let mut address = [0; 8];
            address.copy_from_slice(&bytes[member.offset..member.offset + 8]);
            let Some(buffer) = device.buffer_at(u64::from_le_bytes(address)) else { continue };
            for (list, wanted) in [(&mut read, reads), (&mut written, writes)] {
                if wanted && !list.contains(&buffer) {
                    list.push(buffer);
                }
            }
        }
        let sum = |list: Vec<(u64, u64)>| list.iter().map(|b| b.1).sum();
        Self { read: sum(read), written: sum(written) }
    }
}

impl Device {
    /// Start and bytes of the buffer that `address` lies in.
    fn buffer_at(&self, address: u64) -> Option<(u64, u64)> {
        let buffers = lock(&self.buffers);
        let (start, bytes) = buffers.range(..=address).next_back()?;
        (address - start < *bytes).then_some((*start, *bytes))
    }

    /// A time of the host and the tick of the device's clock that it was, with how far they may be apart.
    fn clocks(&self) -> Option<(Instant, u64, Duration)> {
        let loader = self.calibrated.as_ref()?;
        let domain = [vk::CalibratedTimestampInfoEXT::default().time_domain(vk::TimeDomainEXT::DEVICE)];
        let before = Instant::now();
        // SAFETY: the device is alive and has the extension and this domain.
        let (ticks, _) = unsafe { loader.get_calibrated_timestamps(&domain) }.ok()?;
        let half = before.elapsed() / 2;
        Some((before + half, *ticks.first()?, half))
    }
}

/// Invocations by pass, as the device counts them.
pub(super) struct Statistics {
    pool: vk::QueryPool,
    /// Passes that it has room for.
    room: u32,
}

impl Statistics {
    /// Room for `room` passes; none where the device counts nothing.
    pub(super) fn new(device: &Device, room: u32) -> Result<Option<Self>> {
        if !device.info.has_statistics {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::PIPELINE_STATISTICS)
            .pipeline_statistics(vk::QueryPipelineStatisticFlags::COMPUTE_SHADER_INVOCATIONS)
            .query_count(room);
        // SAFETY: the device has the feature.
        let pool = device.taking("query pool", || unsafe { device.raw.create_query_pool(&info, None) })?;
        Ok(Some(Self { pool, room }))
    }

    pub(super) fn reset(&self, device: &Device, commands: vk::CommandBuffer) {
        // SAFETY: recording; all queries of the pool.
        unsafe { device.raw.cmd_reset_query_pool(commands, self.pool, 0, self.room) };
    }

    pub(super) fn begin(&self, device: &Device, commands: vk::CommandBuffer, pass: usize) {
        if pass < self.room as usize {
            let flags = vk::QueryControlFlags::empty();
            // SAFETY: recording; reset at the start, begun once, ended by `end`.
            unsafe { device.raw.cmd_begin_query(commands, self.pool, pass as u32, flags) };
        }
    }

    pub(super) fn end(&self, device: &Device, commands: vk::CommandBuffer, pass: usize) {
        if pass < self.room as usize {
            // SAFETY: recording; `begin` began it.
            unsafe { device.raw.cmd_end_query(commands, self.pool, pass as u32) };
        }
    }

    /// What was counted for `pass`, a dispatch of a submit that has finished.
    pub(super) fn read(&self, device: &Device, pass: usize) -> Result<Option<u64>> {
        if pass >= self.room as usize {
            return Ok(None);
        }
        let mut count = [0u64];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: begun and ended by the submit that has finished.
        unsafe { device.raw.get_query_pool_results(self.pool, pass as u32, &mut count, flags) }
            .context("pipeline statistics")?;
        Ok(Some(count[0]))
    }

    pub(super) fn destroy(&self, device: &Device) {
        // SAFETY: no submit that uses it is pending.
        unsafe { device.raw.destroy_query_pool(self.pool, None) };
    }
}

/// When the device began a submit that was given to it at `at` and took it `device_ms` of `wall_ms`, `since_ms` before its
/// clock was looked at; and how far that may be off.
pub(super) fn placed(
    device: &Device,
    at: Instant,
    [wall_ms, device_ms]: [f64; 2],
    since_ms: impl Fn(u64) -> f64,
) -> (Instant, Option<f64>) {
    let Some((now, tick, unsure)) = device.clocks() else { return (at, None) };
    let began = now.checked_sub(milliseconds(since_ms(tick))).unwrap_or(at);
    let latest = at + milliseconds(wall_ms - device_ms);
    (began.min(latest).max(at), Some(unsure.as_secs_f64() * 1e3))
}

/// A duration of so many milliseconds; none below 0.
pub(super) fn milliseconds(ms: f64) -> Duration {
    Duration::try_from_secs_f64(ms.max(0.0) * 1e-3).unwrap_or_default()
}
