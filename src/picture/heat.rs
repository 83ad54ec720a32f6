//! Maps of what pixels cost, in colours whose lightness rises evenly.

use super::pixels::{LETTER, Picture, oklch, text_width};
use glam::Vec3;

/// The colour of `share` in [0, 1], linear light: from near black by violet and orange to pale yellow. Lightness rises
/// evenly, so that order shows, in print and to colour-blind eyes too.
pub(crate) fn heat(share: f32) -> Vec3 {
    let x = share.clamp(0.0, 1.0);
    oklch(0.16 + 0.80 * x, 0.05 + 0.14 * (std::f32::consts::PI * (0.1 + 0.78 * x)).sin(), 285.0 + 178.0 * x)
}

/// A whole number, round, that times four is a scale's end at or above `most`.
fn step_for(most: f64) -> f64 {
    let mut power = 1.0;
    loop {
        for digit in [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0] {
            let step: f64 = digit * power;
            if step.fract() == 0.0 && 4.0 * step >= most {
                return step;
            }
        }
        power *= 10.0;
    }
}

/// The end of a scale for `values`. A few pixels of very much would leave the rest dark: they share the last colour.
pub(crate) fn scale_end(values: &[f32]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    4.0 * step_for(f64::from(sorted.get(sorted.len() * 995 / 1000).copied().unwrap_or(0.0)))
}

/// A map of `values`, none below 0, with a legend below: a bar of colours from 0 to `end`, numbers under it, and over it
/// what is shown.
pub(crate) fn heat_map(width: usize, values: &[f32], unit: &str, end: f64) -> Picture {
    let most = values.iter().fold(0.0, |m: f32, x| m.max(*x));
    let mean = values.iter().map(|x| f64::from(*x)).sum::<f64>() / values.len().max(1) as f64;
    let light: Vec<Vec3> = values.iter().map(|x| heat((f64::from(*x) / end) as f32)).collect();
    let map = Picture::of(width, &light);

    let title = format!("{unit}: mean {mean:.1}, most {most:.0}");
    // Titles take some 40 letters.
    let size = (width / 480).max(1);
    let (margin, letter) = (8 * size, LETTER * size);
    let (bar_y, bar_height) = (map.height + margin + letter + margin / 2, 2 * letter);
    let numbers_y = bar_y + bar_height + margin / 2;
    let (ground, ink) = (Vec3::splat(0.008), Vec3::splat(0.8));
    let mut picture = Picture::new(width, numbers_y + letter + margin, ground);
    picture.put(0, 0, &map);
    picture.write(&title, margin, map.height + margin, size, ink);
    let length = width.saturating_sub(2 * margin).max(1);
    for x in 0..length {
        for y in 0..bar_height {
            picture.set(margin + x, bar_y + y, heat(x as f32 / length as f32));
        }
    }
    for tick in 0..=4 {
        let at = margin + tick * (length - 1) / 4;
        let beyond = if tick == 4 && f64::from(most) > end { "+" } else { "" };
        let number = format!("{}{beyond}", end * tick as f64 / 4.0);
        let half = text_width(&number, size) / 2;
        let from =
            at.saturating_sub(half).clamp(margin, (width.saturating_sub(margin + 2 * half)).max(margin));
        picture.write(&number, from, numbers_y, size, ink);
        for y in 0..margin / 2 {
            picture.set(at, bar_y + bar_height + y.saturating_sub(1), ink);
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_rises_in_luminance() {
        let luminance = |i: u16| heat(f32::from(i) / 255.0).dot(Vec3::new(0.2126, 0.7152, 0.0722));
        for i in 1..=255 {
            assert!(luminance(i) > luminance(i - 1), "step {i}");
        }
    }

    #[test]
    fn scales_end_above_their_counts() {
        for (most, step) in
            [(0.0, 1.0), (4.0, 1.0), (5.0, 2.0), (99.0, 25.0), (401.0, 150.0), (250_000.0, 80_000.0)]
        {
            assert_eq!(step_for(most), step, "{most}");
        }
    }

    #[test]
    fn maps_of_any_size() {
        for (width, height) in [(1, 1), (3, 2), (40, 5), (2000, 1)] {
            let map = heat_map(width, &vec![7.0; width * height], "box tests a ray", 8.0);
            assert_eq!(map.width, width);
            assert_eq!(map.pixels.len(), map.width * map.height);
            assert!(map.height > height);
        }
    }
}
