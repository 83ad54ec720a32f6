//! The job files of `.ci/jobs`, run as their engines run them: arguments, environment and folders as Slurm and GitHub
//! Actions give them.

#![allow(clippy::unwrap_used)]

use crate::bench::{folder, rows};
use crate::cli::Folder;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use yaml_rust2::{Yaml, YamlLoader};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Four cells, each a build and two sets of rays.
const ARGS: [&str; 12] = [
    "sphere:2k",
    "hairball:2k",
    "--preset",
    "quick",
    "--runs",
    "1",
    "--views",
    "1",
    "--builders",
    "ploc,wide-leaves",
    "--rays",
    "primary,ao",
];

/// A program in the folder, with the tests' own boxwood.
fn command(folder: &Folder, program: &str) -> Command {
    let mut command = Command::new(program);
    let boxwood = folder.command(&[]);
    command.current_dir(folder.path("")).env("BOXWOOD", env!("CARGO_BIN_EXE_boxwood"));
    for (name, value) in boxwood.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
}

/// Arguments, with the presets' file wherever the program runs.
fn args(folder: &Folder) -> Vec<String> {
    let presets = folder.path("presets.toml").display().to_string();
    ARGS.into_iter().map(str::to_owned).chain(["--presets".into(), presets]).collect()
}

fn succeeds(command: &mut Command) -> String {
    let out = command.output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{command:?}: {said}");
    said
}

/// Measures all of it in one go, into `whole`.
fn measure_whole(folder: &Folder) {
    succeeds(
        command(folder, env!("CARGO_BIN_EXE_boxwood"))
            .arg("bench")
            .args(args(folder))
            .args(["--out", "whole"]),
    );
}

/// A task of the array 1-`count`, as Slurm runs it: a copy of the file, its folder said in the environment.
fn slurm_task(folder: &Folder, index: usize, count: usize) -> Command {
    fs::create_dir_all(folder.path("spool")).unwrap();
    fs::copy(format!("{ROOT}/.ci/jobs/bench.sbatch"), folder.path("spool/slurm_script")).unwrap();
    let mut command = command(folder, "bash");
    command.arg(folder.path("spool/slurm_script")).args(args(folder)).current_dir("/");
    command.env("SLURM_SUBMIT_DIR", ROOT).env("BOXWOOD_OUT", folder.path("results"));
    command.env("SLURM_ARRAY_TASK_ID", index.to_string()).env("SLURM_ARRAY_TASK_COUNT", count.to_string());
    command.env_remove("BOXWOOD_SHARDS");
    command
}

#[test]
fn slurm_arrays_outlive_kills() {
    let folder = folder();
    succeeds(&mut slurm_task(&folder, 1, 2));
    // The second is killed once it has rows, as by a node that is lost, in the middle of a line.
    let path = folder.path("results/2-of-2/rows.jsonl");
    let text = || fs::read_to_string(&path).unwrap_or_default();
    let mut task = slurm_task(&folder, 2, 2).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while text().lines().count() < 3 && task.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    task.kill().unwrap();
    task.wait().unwrap();
    let cut = text();
    let last = cut.trim_end().rfind('\n').unwrap();
    fs::write(&path, &cut[..last + 30]).unwrap();
    // What there is can be merged, and is said not to be all.
    let merge = |out: &str| {
        let mut merge = command(&folder, env!("CARGO_BIN_EXE_boxwood"));
        succeeds(merge.args(["report", "merge", "results/1-of-2", "results/2-of-2", "--out", out]))
    };
    assert!(merge("part").contains("missing: hairball:2k, "), "{}", merge("part"));
    assert!(fs::read_to_string(folder.path("part/report.html")).unwrap().contains("rows are missing"));
    let said = succeeds(&mut slurm_task(&folder, 2, 2));
    assert!(said.contains("resuming: ") && !said.contains("resuming: 0 "), "{said}");
    merge("merged");
    measure_whole(&folder);
    assert_eq!(rows(&folder, "merged/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    let page = fs::read_to_string(folder.path("merged/report.html")).unwrap();
    assert!(!page.contains("missing"));
    let mut names: Vec<_> =
        fs::read_dir(folder.path("results")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["1-of-2", "2-of-2"]);
}

#[test]
fn slurm_tasks_need_slurm() {
    let folder = folder();
    for (missing, said) in [("SLURM_SUBMIT_DIR", "sbatch"), ("SLURM_ARRAY_TASK_COUNT", "--array")] {
        let out = slurm_task(&folder, 1, 2).env_remove(missing).output().unwrap();
        let stderr = String::from_utf8(out.stderr).unwrap();
        assert!(!out.status.success() && stderr.contains(said), "{stderr}");
    }
    let wrong = command(&folder, &format!("{ROOT}/.ci/jobs/shard")).arg("2of3").output().unwrap();
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8(wrong.stderr).unwrap().contains("usage: "));
}

/// As much of GitHub Actions as the workflow needs.
struct Actions {
    /// Where artifacts are kept.
    store: PathBuf,
    /// What `${{ … }}` stands for.
    contexts: Vec<(String, String)>,
}

impl Actions {
    /// A text with its expressions in place.
    fn text(&self, yaml: &Yaml) -> String {
        let text = yaml.as_str().unwrap();
        let filled = self
            .contexts
            .iter()
            .fold(text.to_owned(), |text, (name, value)| text.replace(&format!("${{{{ {name} }}}}"), value));
        assert!(!filled.contains("${{"), "{filled}");
        filled
    }

    /// Runs the steps of a job in `checkout`, a folder of its own; those that set up what is there already are named.
    fn job(&self, folder: &Folder, job: &Yaml, checkout: &Path) -> Vec<String> {
        fs::create_dir_all(checkout.join("target/release")).unwrap();
        std::os::unix::fs::symlink(Path::new(ROOT).join(".ci"), checkout.join(".ci")).unwrap();
        let program = checkout.join("target/release/boxwood");
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_boxwood"), program).unwrap();
        let mut skipped = vec![];
        for step in job["steps"].as_vec().unwrap() {
            let with = |name: &str| self.text(&step["with"][name]);
            match (step["uses"].as_str(), step["run"].as_str()) {
                (Some("actions/checkout@v4"), None) => {}
                (Some("actions/upload-artifact@v4"), None) => {
                    copy(&checkout.join(with("path")), &self.store.join(with("name")));
                }
                (Some("actions/download-artifact@v4"), None) => {
                    assert_eq!(
                        (with("pattern").as_str(), step["with"]["merge-multiple"].as_bool()),
                        ("shard-*", Some(true))
                    );
                    for artifact in fs::read_dir(&self.store).unwrap() {
                        copy(&artifact.unwrap().path(), &checkout.join(with("path")));
                    }
                }
                (None, Some(line)) if line.starts_with(".ci/setup ") || line.starts_with("cargo ") => {
                    skipped.push(line.to_owned());
                }
                (None, Some(_)) => {
                    let mut shell = command(folder, "bash");
                    shell
                        .args(["-e", "-o", "pipefail", "-c", &self.text(&step["run"])])
                        .current_dir(checkout);
                    for (name, value) in step["env"].as_hash().into_iter().flatten() {
                        shell.env(name.as_str().unwrap(), self.text(value));
                    }
                    succeeds(&mut shell);
                }
                other => panic!("a step of another kind: {other:?}"),
            }
        }
        skipped
    }
}

/// Copies what is in a folder into another.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &name);
        } else {
            fs::copy(&path, &name).unwrap();
        }
    }
}

#[test]
fn a_github_matrix_makes_the_whole() {
    let folder = folder();
    let text = fs::read_to_string(format!("{ROOT}/.ci/jobs/github.yml")).unwrap();
    let workflow = &YamlLoader::load_from_str(&text).unwrap()[0];
    let (shard, report) = (&workflow["jobs"]["shard"], &workflow["jobs"]["report"]);
    assert_eq!(report["needs"].as_str(), Some("shard"));
    let typed = &workflow["on"]["workflow_dispatch"]["inputs"]["args"]["default"];
    assert_eq!(typed.as_str(), Some("--preset quick"));
    let matrix = shard["strategy"]["matrix"]["shard"].as_vec().unwrap();
    let mut actions = Actions { store: folder.path("store"), contexts: vec![] };
    for (i, value) in matrix.iter().enumerate() {
        let value = value.as_i64().unwrap().to_string();
        assert_eq!(value, (i + 1).to_string(), "shards count from 1");
        actions.contexts = vec![
            ("matrix.shard".into(), value.clone()),
            ("strategy.job-total".into(), matrix.len().to_string()),
            ("inputs.args".into(), args(&folder).join(" ")),
        ];
        let skipped = actions.job(&folder, shard, &folder.path(&format!("runner-{value}")));
        assert_eq!(skipped, [".ci/setup bench"]);
    }
    let skipped = actions.job(&folder, report, &folder.path("runner-report"));
    assert_eq!(skipped, [".ci/setup bench", "cargo build --release --locked"]);
    measure_whole(&folder);
    assert_eq!(rows(&folder, "store/merged/rows.jsonl"), rows(&folder, "whole/rows.jsonl"));
    for name in ["report.html", "bench.json", "bench.csv"] {
        assert!(folder.path("store/merged").join(name).is_file(), "{name}");
    }
}
