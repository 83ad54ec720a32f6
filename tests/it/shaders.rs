//! What the modules say: spirv-val on each, and how invocations hand values to each other.

#![allow(clippy::unwrap_used)]

use boxwood::{abi, kernels};
use std::collections::HashMap;
use std::process::Command;

#[test]
fn every_module_is_valid() {
    let dir = tempfile::tempdir().unwrap();
    assert!(kernels::ALL.len() > 10);
    for (name, [words, pairs]) in kernels::ALL {
        for (kind, bytes) in [("words", words), ("pairs", pairs)] {
            let path = dir.path().join(format!("{}.{kind}.spv", name.replace('/', "_")));
            std::fs::write(&path, bytes).unwrap();
            let out = Command::new("spirv-val")
                .args(["--target-env", "vulkan1.2", "--scalar-block-layout"])
                .arg(&path)
                .output()
                .unwrap_or_else(|e| panic!("spirv-val did not start ({e}); run `make setup`"));
            let said =
                String::from_utf8_lossy(&out.stderr).into_owned() + &String::from_utf8_lossy(&out.stdout);
            assert!(out.status.success() && said.trim().is_empty(), "{name} ({kind}): {said}");
        }
    }
}

// Instructions, by the SPIR-V specification.
const NAME: u32 = 5;
const MEMORY_MODEL: u32 = 14;
const TYPE_POINTER: u32 = 32;
const CONSTANT: u32 = 43;
const LOAD: u32 = 61;
const STORE: u32 = 62;
const ACCESS_CHAIN: u32 = 65;
const DECORATE: u32 = 71;
const MEMBER_DECORATE: u32 = 72;
const CONTROL_BARRIER: u32 = 224;
const MEMORY_BARRIER: u32 = 225;
const ATOMIC_LOAD: u32 = 227;
const ATOMIC_STORE: u32 = 228;
/// Its own, and those of one read and one write without a condition: exchange, and from add to exclusive or.
const READ_AND_WRITE: [u32; 12] = [229, 232, 233, 234, 235, 236, 237, 238, 239, 240, 241, 242];
const COMPARE: [u32; 3] = [230, 231, 318];
// Their operands.
const VULKAN: u32 = 3;
const PHYSICAL_STORAGE_BUFFER: u32 = 5349;
const QUEUE_FAMILY: u32 = 5;
const WORKGROUP: u32 = 2;
const VOLATILE: u32 = 1;
const MAKE_AVAILABLE: u32 = 8;
const MAKE_VISIBLE: u32 = 16;
const NON_PRIVATE: u32 = 32;
const DECORATION_VOLATILE: u32 = 21;
const DECORATION_COHERENT: u32 = 23;
/// Acquires and releases, makes available and visible, in buffers.
const HAND_OVER: u32 = 0x8 | 0x2000 | 0x4000 | 0x40;

/// A module as far as it accesses memory.
struct Module {
    /// Opcode and operands.
    instructions: Vec<(u32, Vec<u32>)>,
    constants: HashMap<u32, u32>,
    /// The buffer, an argument of the kernel, that pointers point into.
    buffers: HashMap<u32, String>,
}

impl Module {
    fn read(bytes: &[u8]) -> Self {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        let (mut at, mut instructions) = (5, vec![]);
        while at < words.len() {
            let length = (words[at] >> 16) as usize;
            instructions.push((words[at] & 0xffff, words[at + 1..at + length].to_vec()));
            at += length;
        }
        let (mut names, mut types, mut buffers) = (HashMap::new(), HashMap::new(), HashMap::new());
        let mut constants = HashMap::new();
        for (op, w) in &instructions {
            match *op {
                NAME => {
                    let text: Vec<u8> = w[1..].iter().flat_map(|w| w.to_le_bytes()).collect();
                    let text = String::from_utf8_lossy(&text);
                    if let Some(name) = text.trim_end_matches('\0').strip_prefix("Buffer_") {
                        names.insert(w[0], name.to_owned());
                    }
                }
                CONSTANT => {
                    constants.insert(w[1], w[2]);
                }
                TYPE_POINTER if w[1] == PHYSICAL_STORAGE_BUFFER => {
                    if let Some(name) = names.get(&w[2]) {
                        types.insert(w[0], name.clone());
                    }
                }
                ACCESS_CHAIN => {
                    if let Some(name) = buffers.get(&w[2]).cloned() {
                        buffers.insert(w[1], name);
                    }
                }
                // Anything else that comes to a pointer to a buffer.
                _ => {
                    if let Some(name) = w.first().and_then(|ty| types.get(ty)).filter(|_| w.len() > 1) {
                        buffers.insert(w[1], name.clone());
                    }
                }
            }
        }
        Self { instructions, constants, buffers }
    }

    /// The buffer and memory operands of each load and store there, none where there are none.
    fn accesses(&self) -> impl Iterator<Item = (&str, u32)> {
        self.instructions.iter().filter_map(|(op, w)| {
            let (pointer, operands) = match *op {
                LOAD => (w[2], w.get(3)),
                STORE => (w[0], w.get(2)),
                _ => return None,
            };
            Some((self.buffers.get(&pointer)?.as_str(), operands.copied().unwrap_or(0)))
        })
    }

    /// The buffer, if it is one, scope, semantics and added value of each atomic that reads and writes.
    fn atomics(&self) -> impl Iterator<Item = (Option<&str>, [Option<u32>; 3])> {
        self.instructions.iter().filter(|(op, _)| READ_AND_WRITE.contains(op)).map(|(_, w)| {
            let constant = |i: usize| w.get(i).and_then(|id| self.constants.get(id)).copied();
            (self.buffers.get(&w[2]).map(String::as_str), [constant(3), constant(4), constant(5)])
        })
    }

    /// Execution scope, memory scope and semantics of each control barrier.
    fn barriers(&self) -> impl Iterator<Item = [u32; 3]> {
        let all = self.instructions.iter().filter(|(op, _)| *op == CONTROL_BARRIER);
        all.map(|(_, w)| [w[0], w[1], w[2]].map(|id| self.constants[&id]))
    }

    fn count(&self, op: u32) -> usize {
        self.instructions.iter().filter(|i| i.0 == op).count()
    }
}

/// Every module with its name and its kernel's arguments.
fn modules() -> impl Iterator<Item = (String, &'static abi::Struct, Module)> {
    kernels::ALL.iter().flat_map(|(name, spirv)| {
        let args = abi::structs().find(|s| s.kernels.contains(name)).unwrap();
        spirv.map(|bytes| (format!("{name}, {} bytes", bytes.len()), args, Module::read(bytes)))
    })
}

#[test]
fn values_are_handed_over_by_the_memory_model() {
    let mut handing = vec![];
    for (name, args, module) in modules() {
        let shared: Vec<&str> =
            args.members.iter().filter(|m| m.ty.starts_with("PtrShared")).map(|m| m.name).collect();
        let model = &module.instructions.iter().find(|i| i.0 == MEMORY_MODEL).unwrap().1;
        assert_eq!(model[1] == VULKAN, !shared.is_empty(), "{name}: the memory model");
        assert_eq!(module.count(MEMORY_BARRIER), 0, "{name}: a barrier that hands over nothing at an atomic");
        let mut seen = HashMap::new();
        for (buffer, operands) in module.accesses() {
            *seen.entry(buffer).or_insert(0) += 1;
            let non_private = operands & NON_PRIVATE != 0;
            assert_eq!(
                non_private,
                shared.contains(&buffer),
                "{name}: a load or store of {buffer}: {operands:#x}"
            );
        }
        let mut hand_overs = 0;
        for (buffer, [scope, semantics, _]) in module.atomics() {
            let buffer = buffer.unwrap_or_else(|| panic!("{name}: an atomic outside buffers"));
            if shared.contains(&buffer) {
                let said = (scope, semantics);
                assert_eq!(said, (Some(QUEUE_FAMILY), Some(HAND_OVER)), "{name}: an atomic on {buffer}");
                *seen.entry(buffer).or_insert(0) += 1;
                hand_overs += 1;
            } else {
                assert_eq!(semantics, Some(0), "{name}: an atomic on {buffer}, which hands over nothing");
            }
        }
        hand_overs += module.barriers().filter(|b| *b == [WORKGROUP, WORKGROUP, HAND_OVER]).count();
        assert_eq!(hand_overs > 0, !shared.is_empty(), "{name}: {hand_overs} hand-overs");
        for buffer in shared {
            assert!(seen.contains_key(buffer), "{name}: {buffer} is never accessed");
            handing.push(name.split(',').next().unwrap().to_owned());
        }
    }
    handing.dedup();
    assert_eq!(handing, ["dito/extremes", "lbvh/climb", "odopfit/climb", "ploc/tail", "recut/climb"]);
}

#[test]
fn nothing_can_wait_for_another_workgroup() {
    // Who waits must read again and again what another writes: by an atomic that only reads, or writes on a condition, or
    // adds nothing; or by a load that makes visible. No kernel has one, so no loop of any can be left by another's doing.
    for (name, _, module) in modules() {
        for op in [ATOMIC_LOAD, ATOMIC_STORE].into_iter().chain(COMPARE) {
            assert_eq!(module.count(op), 0, "{name}: instruction {op}");
        }
        for (buffer, [.., added]) in module.atomics() {
            assert_ne!(added, Some(0), "{name}: an atomic on {buffer:?} that only reads");
        }
        for (buffer, operands) in module.accesses() {
            let flags = VOLATILE | MAKE_AVAILABLE | MAKE_VISIBLE;
            assert_eq!(operands & flags, 0, "{name}: a load or store of {buffer}: {operands:#x}");
        }
        for (op, w) in &module.instructions {
            let decoration = match *op {
                DECORATE => w[1],
                MEMBER_DECORATE => w[2],
                _ => continue,
            };
            assert!(
                ![DECORATION_VOLATILE, DECORATION_COHERENT].contains(&decoration),
                "{name}: {decoration}"
            );
        }
    }
}
