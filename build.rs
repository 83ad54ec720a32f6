//! Compiles every kernel `glsl/<stage>/<verb>.comp` to SPIR-V, twice: with and without 64-bit integers
//! and floats. Buffers are device
//! addresses. Writes `kernels.rs` (one constant a kernel) and refuses a kernel whose member offsets differ
//! from the host's. Also puts the commit into `BOXWOOD_COMMIT`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

#[allow(dead_code)]
#[path = "src/abi/mod.rs"]
mod abi;

const GLSL: &str = "glsl";
/// Name, 64-bit integers and floats: in the order of `Kernel::spirv`.
const MODES: [(&str, bool); 2] = [("narrow", false), ("wide", true)];

/// For kernels whose invocations hand values to each other: see `glsl/lib/handover.glsl`. The others have no use for it, and
/// in it each access to a workgroup's own memory is a barrier to some drivers.
const MEMORY_MODEL: &str =
    "#pragma use_vulkan_memory_model\n#extension GL_KHR_memory_scope_semantics : require\n";

fn main() {
    println!("cargo:rerun-if-changed={GLSL}");
    println!("cargo:rerun-if-changed=src/abi");
    if Path::new(".git/logs/HEAD").exists() {
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
    }
    println!("cargo:rustc-env=BOXWOOD_COMMIT={}", commit());
    if let Err(message) = kernels() {
        eprintln!("{message}");
        process::exit(1);
    }
}

/// The commit being built, `+` where the tree has changes, `unknown` outside a checkout.
fn commit() -> String {
    let git = |args: &[&str]| {
        let out = process::Command::new("git").args(args).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&out.stdout).trim().to_owned())
    };
    let Some(hash) = git(&["rev-parse", "--short=12", "HEAD"]) else { return "unknown".into() };
    let dirty = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|s| !s.is_empty());
    hash + if dirty { "+" } else { "" }
}

fn kernels() -> Result<(), String> {
    let out_dir = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: run through cargo")?);
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc did not start: {e}"))?;
    let prelude = fs::read_to_string("glsl/prelude.glsl").map_err(|e| format!("glsl/prelude.glsl: {e}"))?;
    let mut constants = String::new();
    let mut all = String::new();
    for (name, path) in sources(Path::new(GLSL))? {
        let args = abi::structs()
            .find(|s| s.kernels.contains(&name.as_str()))
            .ok_or_else(|| format!("{}: src/abi has no struct `@kernel \"{name}\"`", path.display()))?;
        let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let stem = name.replace('/', "_");
        for (mode, wide) in MODES {
            let source = format!(
                "#version 460\n{}{}{prelude}\n{}{}#line 1\n{text}",
                if wide { "#define WIDE\n" } else { "" },
                if hands_over(args) { MEMORY_MODEL } else { "" },
                elements(),
                arguments(args)
            );
            let spirv = compile(&compiler, &source, &path)?;
            check_offsets(spirv.as_binary(), &name, mode)?;
            let file = out_dir.join(format!("{stem}.{mode}.spv"));
            fs::write(&file, spirv.as_binary_u8()).map_err(|e| format!("{}: {e}", file.display()))?;
        }
        let _ = writeln!(
            constants,
            "/// `glsl/{name}.comp`\npub const {}: Kernel<abi::{}> = Kernel::new(\"{name}\", [{}]);",
            stem.to_uppercase(),
            args.name,
            MODES
                .map(|m| format!("include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{stem}.{}.spv\"))", m.0))
                .join(", ")
        );
        let constant = stem.to_uppercase();
        let _ = writeln!(all, "    (\"{name}\", {constant}.spirv),");
    }
    let _ = writeln!(
        constants,
        "/// Every kernel: its name and its SPIR-V, without and with 64-bit loads.\n\
         pub const ALL: &[(&str, [&[u8]; 2])] = &[\n{all}];"
    );
    for (s, kernel) in abi::structs().flat_map(|s| s.kernels.iter().map(move |k| (s, k))) {
        if !Path::new(GLSL).join(format!("{kernel}.comp")).exists() {
            return Err(format!("src/abi: {} names kernel {kernel}, which glsl/ lacks", s.name));
        }
    }
    fs::write(out_dir.join("kernels.rs"), constants).map_err(|e| format!("kernels.rs: {e}"))
}

/// All `.comp` files below `dir` as (`stage/verb`, path), in name order.
fn sources(dir: &Path) -> Result<BTreeMap<String, PathBuf>, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(dir).map_err(|e| format!("{}: {e}", dir.display()))? {
        let path = entry.map_err(|e| format!("{}: {e}", dir.display()))?.path();
        if path.is_dir() {
            found.extend(sources(&path)?);
        } else if path.extension().is_some_and(|e| e == "comp") {
            let name = path.strip_prefix(GLSL).map_err(|e| e.to_string())?.with_extension("");
            found.insert(name.to_string_lossy().replace('\\', "/"), path);
        }
    }
    Ok(found)
}

fn compile(
    compiler: &shaderc::Compiler,
    source: &str,
    path: &Path,
) -> Result<shaderc::CompilationArtifact, String> {
    let mut options = shaderc::CompileOptions::new().map_err(|e| format!("shaderc options: {e}"))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_5);
    // Member names must survive for `check_offsets`; drivers optimise by themselves.
    options.set_optimization_level(shaderc::OptimizationLevel::Zero);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|wanted, _, _, _| {
        let file = Path::new(GLSL).join(wanted);
        let content = fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(shaderc::ResolvedInclude { resolved_name: file.to_string_lossy().into_owned(), content })
    });
    compiler
        .compile_into_spirv(
            source,
            shaderc::ShaderKind::Compute,
            &path.to_string_lossy(),
            "main",
            Some(&options),
        )
        .map_err(|e| e.to_string())
}

enum Type {
    Plain(String),
    Pointer { element: String, qualifier: &'static str },
}

/// What a Rust type of `abi` is in GLSL.
fn glsl_type(rust: &str) -> Type {
    let t: String = rust.chars().filter(|c| !c.is_whitespace()).collect();
    let plain = |t: &str| {
        match t {
            "f32" => "float",
            "u32" => "uint",
            "i32" => "int",
            "[f32;2]" => "vec2",
            "[f32;3]" => "vec3",
            "[f32;4]" => "vec4",
            "[u32;2]" => "uvec2",
            "[u32;3]" => "uvec3",
            "[u32;4]" => "uvec4",
            "Pair" => "PAIR",
            other => other,
        }
        .to_owned()
    };
    // Of the array, not of its block: the compiler passes some on to it, but not `nonprivate`.
    for (prefix, qualifier) in
        [("Ptr<", "readonly restrict"), ("PtrMut<", "restrict"), ("PtrShared<", "nonprivate")]
    {
        if let Some(element) = t.strip_prefix(prefix) {
            let element = element.trim_end_matches('>');
            let element =
                if abi::PAIRS.contains(&element) { format!("{element}Pairs") } else { plain(element) };
            return Type::Pointer { element, qualifier };
        }
    }
    Type::Plain(plain(&t))
}

/// Whether a kernel of these arguments has buffers through which invocations hand values to each other.
fn hands_over(args: &abi::Struct) -> bool {
    args.members.iter().any(|m| m.ty.starts_with("PtrShared"))
}

/// Constants and element structs.
fn elements() -> String {
    let mut out = String::new();
    for (name, value) in abi::CONSTANTS {
        let _ = writeln!(out, "#define {name} {value}u");
    }
    for s in abi::structs().filter(|s| s.kernels.is_empty()) {
        out += &structure(s);
        if abi::PAIRS.contains(&s.name) {
            out += &pairs(s);
        }
    }
    out
}

/// `LOAD_S(buffer, i)` and `STORE_S(buffer, i, value)` for a struct that buffers hold as pairs of words.
fn pairs(s: &abi::Struct) -> String {
    let mut words = vec![];
    flatten(s, "s", &mut words);
    let n = words.len() / 2;
    let name = s.name;
    let list = |f: &dyn Fn(usize) -> String| (0..n).map(f).collect::<Vec<_>>().join(", ");
    let mut out = format!("{name} {name}_of({}) {{\n    {name} s;\n", list(&|i| format!("PAIR p{i}")));
    for i in 0..n {
        let _ = writeln!(out, "    uvec2 w{i} = words_of(p{i});");
    }
    for (i, (word, float)) in words.iter().enumerate() {
        let from = format!("w{}.{}", i / 2, ["x", "y"][i % 2]);
        let _ =
            writeln!(out, "    {word} = {};", if *float { format!("uintBitsToFloat({from})") } else { from });
    }
    let _ = writeln!(out, "    return s;\n}}");
    let word = |i: usize| {
        let (word, float) = &words[i];
        if *float { format!("floatBitsToUint({word})") } else { word.clone() }
    };
    for i in 0..n {
        let (x, y) = (word(2 * i), word(2 * i + 1));
        let _ = writeln!(out, "PAIR {name}_pair{i}({name} s) {{ return pair_of(uvec2({x}, {y})); }}");
    }
    let _ = writeln!(out, "struct {name}Pairs {{ PAIR p[{n}]; }};");
    let at = |i: usize| format!("P(b).at[i].p[{i}]");
    let _ = writeln!(out, "#define LOAD_{name}(b, i) {name}_of({})", list(&at));
    let stores: Vec<String> = (0..n).map(|i| format!("{} = {name}_pair{i}(v);", at(i))).collect();
    let _ = writeln!(out, "#define STORE_{name}(b, i, v) {{ {} }}", stores.join(" "));
    out
}

/// The words of a struct as (GLSL lvalue, is a float).
fn flatten(s: &abi::Struct, path: &str, words: &mut Vec<(String, bool)>) {
    for m in s.members {
        let t: String = m.ty.chars().filter(|c| !c.is_whitespace()).collect();
        let path = format!("{path}.{}", m.name);
        if let Some(inner) = abi::structs().find(|s| s.name == t) {
            flatten(inner, &path, words);
            continue;
        }
        let float = t.contains("f32");
        match t
            .strip_prefix('[')
            .and_then(|t| t.trim_end_matches(']').split(';').nth(1)?.parse::<usize>().ok())
        {
            Some(n) => words.extend((0..n).map(|k| (format!("{path}.{}", ["x", "y", "z", "w"][k]), float))),
            None => words.push((path, float)),
        }
    }
}

fn structure(s: &abi::Struct) -> String {
    let mut out = format!("struct {} {{\n", s.name);
    for m in s.members {
        let ty = match glsl_type(m.ty) {
            Type::Plain(t) => t,
            Type::Pointer { .. } => format!("Buffer_{}", m.name),
        };
        let _ = writeln!(out, "    {ty} {};", m.name);
    }
    out + "};\n"
}

/// One kernel's push constants and the buffers that they point to.
fn arguments(s: &abi::Struct) -> String {
    let mut out = String::new();
    for m in s.members {
        let Type::Pointer { element, qualifier } = glsl_type(m.ty) else { continue };
        let _ = writeln!(
            out,
            "layout(buffer_reference, scalar, buffer_reference_align = {}) buffer Buffer_{} {{ {qualifier} {element} at[]; }};",
            if element.ends_with("Pairs") || element == "PAIR" { 8 } else { 4 },
            m.name,
        );
    }
    out += &structure(s);
    let _ = writeln!(out, "layout(push_constant, scalar) uniform Push {{ {} args; }};", s.name);
    out + "#define P(x) args.x\n"
}

/// Compares every member offset of every shared struct in a module with the host's.
fn check_offsets(words: &[u32], kernel: &str, mode: &str) -> Result<(), String> {
    const OP_NAME: u32 = 5;
    const OP_MEMBER_NAME: u32 = 6;
    const OP_MEMBER_DECORATE: u32 = 72;
    const OFFSET: u32 = 35;
    let text = |w: &[u32]| {
        let bytes: Vec<u8> = w.iter().flat_map(|w| w.to_le_bytes()).take_while(|b| *b != 0).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let (mut names, mut members, mut offsets) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let mut at = 5;
    while at < words.len() {
        let (len, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        let w = &words[at..at + len.max(1)];
        match op {
            OP_NAME => drop(names.insert(w[1], text(&w[2..]))),
            OP_MEMBER_NAME => drop(members.insert((w[1], w[2]), text(&w[3..]))),
            OP_MEMBER_DECORATE if w[3] == OFFSET => drop(offsets.insert((w[1], w[2]), w[4] as usize)),
            _ => {}
        }
        at += len.max(1);
    }
    for ((id, index), offset) in &offsets {
        let (Some(name), Some(member)) = (names.get(id), members.get(&(*id, *index))) else { continue };
        let Some(host) = abi::structs().find(|s| s.name == name) else { continue };
        match host.members.iter().find(|m| m.name == member) {
            Some(m) if m.offset == *offset => {}
            Some(m) => {
                return Err(format!(
                    "{kernel} ({mode}): {name}.{member} is at {offset} in GLSL and {} in Rust",
                    m.offset
                ));
            }
            None => return Err(format!("{kernel} ({mode}): {name}.{member} is not in src/abi")),
        }
    }
    Ok(())
}
