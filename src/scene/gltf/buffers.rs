//! Where a glTF's bytes are: in the GLB itself, in a `data:` URI, or in a file beside it. Never elsewhere.

use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::{Root, buffer};
use percent_encoding::percent_decode_str;

use super::DAMAGED;
use crate::scene::siblings::Siblings;
use crate::scene::{Progress, SceneError};

/// With or without `=` at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The buffers of a document, each as long as it says; none: without bytes, as fallbacks of extensions are.
pub(super) struct Buffers(Vec<Option<Vec<u8>>>);

impl Buffers {
    /// Reads them all; `blob` is the GLB's.
    ///
    /// # Errors
    /// A buffer that can't be read, or shorter than it says.
    pub(super) fn load(
        path: &Path,
        root: &Root,
        mut blob: Option<Vec<u8>>,
        siblings: Siblings<'_>,
        progress: Progress,
    ) -> Result<Self, SceneError> {
        let mut all = vec![];
        for (i, buffer) in root.buffers.iter().enumerate() {
            let invalid = |what: String, fix| SceneError::invalid(path, format!("buffer {i}"), what, fix);
            let bytes = match &buffer.uri {
                Some(uri) => Some(read(uri, siblings, progress).map_err(|what| {
                    let uri: String = uri.chars().take(80).collect();
                    invalid(
                        format!("{uri:?} can't be read: {what}"),
                        "put the buffer beside the file, or export a .glb",
                    )
                })?),
                None if i == 0 => blob.take(),
                None => None,
            };
            let Some(mut bytes) = bytes else {
                all.push(None);
                continue;
            };
            if (bytes.len() as u64) < buffer.byte_length.0 {
                let what = format!("it should have {} bytes and has {}", buffer.byte_length.0, bytes.len());
                return Err(invalid(what, DAMAGED));
            }
            bytes.truncate(buffer.byte_length.0 as usize);
            all.push(Some(bytes));
        }
        Ok(Self(all))
    }

    /// Bytes of all buffers.
    pub(super) fn size(&self) -> u64 {
        self.0.iter().flatten().map(|b| b.len() as u64).sum()
    }

    /// The bytes of buffer view `number`.
    pub(super) fn view(&self, number: usize, view: &buffer::View) -> Result<&[u8], String> {
        let b = view.buffer.value();
        let Some(bytes) = &self.0[b] else { return Err(format!("buffer {b} has no bytes")) };
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).filter(|end| *end <= bytes.len() as u64);
        match end {
            Some(end) => Ok(&bytes[start as usize..end as usize]),
            None => {
                Err(format!("buffer view {number} reaches beyond the {} bytes of buffer {b}", bytes.len()))
            }
        }
    }
}

/// What a buffer's URI names.
fn read(uri: &str, siblings: Siblings<'_>, progress: Progress) -> Result<Vec<u8>, String> {
    let percent = |text| -> Vec<u8> { percent_decode_str(text).collect() };
    match uri.split_once(':') {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case("data") => {
            let (kind, data) = rest.split_once(',').ok_or("a data URI without a comma")?;
            if kind.to_ascii_lowercase().ends_with(";base64") {
                BASE64.decode(percent(data)).map_err(|e| format!("its base64 is damaged: {e}"))
            } else {
                Ok(percent(data))
            }
        }
        Some((scheme, _)) if !scheme.contains('/') => Err("only files beside the glTF are read".to_owned()),
        _ => {
            let name = String::from_utf8(percent(uri)).map_err(|_| "its name is no UTF-8")?;
            siblings.read(&name, progress)
        }
    }
}
