//! The scan by one workgroup.

#![allow(clippy::unwrap_used)]

use crate::gpu::quiet;
use crate::soup::Random;
use boxwood::abi::{SPEC_WG, ScanExclusiveArgs};
use boxwood::device::{Buffer, Recorder, Timing};
use boxwood::kernels;
use boxwood::oracle::scan;

#[test]
fn sums_of_any_count() {
    let device = quiet();
    let single = device.shape().single_workgroup;
    for wg in [single, 64] {
        for n in [1u32, 2, wg - 1, wg, wg + 1, 255, 256, 257, 4095, 4096, 4097, 70_001] {
            let mut random = Random(n.into());
            let numbers: Vec<u32> = (0..n).map(|_| random.bits() as u32 >> 12).collect();
            let sums = Buffer::from_slice(&device, "sums", &numbers).unwrap();
            let total = Buffer::<u32>::new(&device, "total", 1).unwrap();
            let mut rec = Recorder::new(&device, Timing::Off).unwrap();
            let args = ScanExclusiveArgs { sums: sums.ptr_mut(), total: total.ptr_mut(), count: n };
            rec.dispatch(&kernels::SCAN_EXCLUSIVE, &[(SPEC_WG, wg)], 1, args).unwrap();
            rec.submit().unwrap();
            let mut expected = numbers;
            let all = scan::exclusive(&mut expected);
            assert_eq!(total.read().unwrap(), [all], "{n} numbers, workgroup {wg}");
            assert_eq!(sums.read().unwrap(), expected, "{n} numbers, workgroup {wg}");
        }
    }
}
