//! Amounts of memory as people write them.

/// Units and what they are in bytes.
const UNITS: [(&str, f64); 5] = [
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("B", 1.0),
];

/// Bytes of a text such as `8GiB`, `512MiB` or `1.5 GiB`; none where it is no amount of at least a byte.
pub fn bytes_of(text: &str) -> Option<u64> {
    let text = text.trim();
    let (number, unit) = UNITS.into_iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit)))?;
    let bytes = number.trim_end().parse::<f64>().ok()? * unit;
    (bytes.is_finite() && bytes >= 1.0).then_some(bytes as u64)
}

#[cfg(test)]
mod tests {
    use super::bytes_of;

    #[test]
    fn sizes_have_units() {
        assert_eq!(bytes_of("8GiB"), Some(8 << 30));
        assert_eq!(bytes_of(" 512 MiB "), Some(512 << 20));
        assert_eq!(bytes_of("1.5KiB"), Some(1536));
        assert_eq!(bytes_of("100B"), Some(100));
        for bad in ["", "8", "8GB", "GiB", "-1GiB", "0B", "infGiB", "nanB"] {
            assert_eq!(bytes_of(bad), None, "{bad}");
        }
    }
}
