//! How much larger the boxes of a tree are than they need be: a sample of them against near-optimal boxes around the same
//! triangles, found by [`super::fits`]' fine search in f64.

use super::dito::corners;
use super::fits::Optimum;
use super::tight::{AXES, boxes_of, least_area};
use crate::abi::{INVALID, TRIANGLE_WORDS};
use crate::bvh::HostTree;
use crate::bvh::frame::Frame;
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// Most triangles below a box of the sample: the search looks at every corner thousands of times.
const MOST: u32 = 256;

/// Area above that of near-optimal boxes, of a sample of a tree's boxes.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Excess {
    /// Boxes of the sample.
    pub boxes: usize,
    /// The sum of their areas over that of near-optimal ones, less 1, per cent.
    pub total: f64,
    /// The mean of each one's, per cent; flat boxes of no area are left out.
    pub mean: f64,
    /// The greatest, per cent.
    pub max: f64,
}

/// Of `sample` boxes of `tree`, evenly spaced among those of at most 256 triangles; unit space less `anchor`. Boxes are
/// those from before they go to a node's grid, in the frame of the node above.
pub fn measure(tree: &HostTree, anchor: [f32; 3], sample: usize) -> Excess {
    if tree.root == INVALID {
        return Excess::default();
    }
    let few: Vec<_> = boxes_of(tree).into_iter().filter(|b| b.count <= MOST).collect();
    let taken = sample.min(few.len());
    let optimum = Optimum::default();
    let areas = |k: usize| {
        let b = &few[k * few.len() / taken];
        debug_assert!(b.first + b.count <= tree.triangles.len() as u32 / TRIANGLE_WORDS);
        let points: Vec<Vec3> = (b.first..b.first + b.count).flat_map(|t| corners(tree, anchor, t)).collect();
        let wide: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
        let frame = b.frame.map(Frame::of);
        let area = frame
            .map_or_else(|| least_area(AXES, 1.0, &points), |f| least_area(f.rows, f.stretch(), &points));
        let own = frame.map_or(DMat3::IDENTITY, |f| {
            DMat3::from_cols_array_2d(&f.rows.map(|r| r.as_dvec3().normalize().to_array()))
        });
        (area, optimum.half_area(&wide, &[own, DMat3::IDENTITY]))
    };
    let areas: Vec<(f64, f64)> = (0..taken).into_par_iter().map(areas).collect();
    let percent = |area: f64, least: f64| if least > 0.0 { 100.0 * (area / least - 1.0) } else { 0.0 };
    let each: Vec<f64> =
        areas.iter().filter(|(_, least)| *least > 0.0).map(|(a, l)| percent(*a, *l)).collect();
    let [area, least] = areas.iter().fold([0.0; 2], |[a, l], (area, least)| [a + area, l + least]);
    Excess {
        boxes: taken,
        total: percent(area, least),
        mean: each.iter().sum::<f64>() / each.len().max(1) as f64,
        max: each.iter().fold(0.0, |m, x| m.max(*x)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{Fit, Recipe};
    use crate::oracle;
    use crate::scene::{Generator, Progress};

    fn excess(generator: Generator, fit: Fit) -> Excess {
        let scene = generator.generate("excess", 3_000, Progress::Quiet).unwrap_or_else(|e| panic!("{e}"));
        let built = oracle::build(&scene, &Recipe { fit, ..Recipe::default() });
        measure(&built.tree, built.space.anchor, 60)
    }

    #[test]
    fn oriented_boxes_have_less_of_it() {
        let city = Generator::CityRotated;
        let [aligned, fitted] = [Fit::Aabb, Fit::Dito(14)].map(|fit| excess(city, fit));
        assert_eq!((aligned.boxes, fitted.boxes), (60, 60));
        assert!(fitted.total < 0.7 * aligned.total && fitted.mean < aligned.mean, "{fitted:?}, {aligned:?}");
        // Along the axes there is nothing to gain.
        let upright = excess(Generator::City, Fit::Aabb);
        assert!(upright.total < 5.0, "{upright:?}");
        for e in [aligned, fitted, upright] {
            assert!(e.mean >= -1e-6 && e.max >= e.mean && e.total >= -1e-6, "{e:?}");
        }
    }

    #[test]
    fn of_nothing_there_is_none() {
        let none = oracle::build(&crate::scene::Scene::default(), &Recipe::default());
        assert_eq!(measure(&none.tree, [0.0; 3], 9), Excess::default());
    }
}
