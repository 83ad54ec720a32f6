//! Files of rays: little-endian f32, eight a ray (origin, t_min, direction, t_max), no header.

use crate::abi::Ray;

/// Bytes of a ray.
const RECORD: usize = size_of::<Ray>();

/// What is no file of rays.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum RayFileError {
    /// Nothing in it.
    #[error("it holds no ray: it is empty; a ray is 8 little-endian f32 (origin, t_min, direction, t_max)")]
    Empty,
    /// The last ray is cut short.
    #[error(
        "{bytes} bytes are no multiple of {RECORD}, so ray {} is cut short; a ray is 8 little-endian f32 (origin, t_min, \
         direction, t_max) and there is no header", bytes / RECORD
    )]
    Cut {
        /// Bytes there are.
        bytes: usize,
    },
}

/// The rays in `bytes`, what is in a file of rays: any bits, to the bit.
///
/// # Errors
/// [`RayFileError`].
pub fn parse(bytes: &[u8]) -> Result<Vec<Ray>, RayFileError> {
    let (records, cut) = bytes.as_chunks::<RECORD>();
    match (records, cut) {
        ([], []) => Err(RayFileError::Empty),
        (_, []) => Ok(records.iter().map(ray).collect()),
        _ => Err(RayFileError::Cut { bytes: bytes.len() }),
    }
}

fn ray(record: &[u8; RECORD]) -> Ray {
    let (words, _) = record.as_chunks::<4>();
    let floats: [f32; RECORD / 4] = std::array::from_fn(|i| f32::from_le_bytes(words[i]));
    bytemuck::cast(floats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_come_in_whole_records() {
        let bytes: Vec<u8> = (0..16).flat_map(|i| (i as f32).to_le_bytes()).collect();
        let rays = parse(&bytes).unwrap();
        assert_eq!((rays.len(), rays[1].t_min, rays[1].t_max), (2, 11.0, 15.0));
        let odd: Vec<u8> = [f32::NAN.to_bits(), 1, 0x7f80_0001, 0xffff_ffff]
            .repeat(2)
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        assert_eq!(bytemuck::bytes_of(&parse(&odd).unwrap()[0]), odd);
        assert_eq!(parse(&bytes[1..]).unwrap_err(), RayFileError::Cut { bytes: 63 });
        assert_eq!(parse(&[]).unwrap_err(), RayFileError::Empty);
        assert!(parse(&bytes[..63]).unwrap_err().to_string().contains("ray 1 is cut short"));
    }
}
