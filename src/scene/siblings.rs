//! Files beside a mesh file that it names: buffers of a glTF, materials of an OBJ. Never one outside its folder,
//! however the name is written and wherever links lead.

use std::path::{Component, Path};

use super::{Progress, mesh};

/// Where a mesh file's siblings are looked for.
#[derive(Debug, Clone, Copy)]
pub enum Siblings<'a> {
    /// In the folder of this file, and below.
    Of(&'a Path),
    /// In memory: by their names, as the mesh file writes them.
    Given(&'a [(&'a str, &'a [u8])]),
    /// Nowhere: the file was fetched by itself.
    None,
}

impl Siblings<'_> {
    /// The whole of the sibling `name`, a relative path.
    ///
    /// # Errors
    /// What keeps it from being read, in words.
    pub(super) fn read(self, name: &str, progress: Progress) -> Result<Vec<u8>, String> {
        let path = match self {
            Self::Of(path) => path,
            Self::Given(files) => {
                let found = files.iter().find(|(given, _)| *given == name);
                return found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| "it was not given".into());
            }
            Self::None => return Err("the mesh was fetched without the files beside it".into()),
        };
        let inward = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        if !Path::new(name).components().all(inward) {
            return Err("it leads out of the file's folder, where nothing is read".into());
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let real = |path: &Path| std::fs::canonicalize(path).map_err(|e| format!("{}: {e}", path.display()));
        let (folder, sibling) = (real(folder)?, real(&folder.join(name))?);
        if !sibling.starts_with(&folder) {
            return Err("it is a link out of the file's folder, where nothing is read".into());
        }
        mesh::read(&sibling, progress).map_err(|e| e.to_string())
    }
}
