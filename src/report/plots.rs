//! Plots as SVG: bars that lie, curves, points. Titles and legends are the page's, so that text there wraps.

use super::{ReportError, Result};
use plotters::coord::Shift;
use plotters::coord::combinators::WithKeyPoints;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Pixels of a plot's width; the page makes it wider, never narrower.
const WIDTH: u32 = 480;
/// Pixels of a bar and the gap below it.
const ROW: u32 = 22;
/// Pixels between two bars of a row's height.
const GAP: u32 = 6;
/// The SVG says 1/1.24 of it: 12 pixels.
const FONT: (&str, u32) = ("sans-serif", 15);
/// Most characters of a bar's label, and the pixels that one may take.
const LABEL: (usize, u32) = (28, 7);
/// By Okabe and Ito, then by Tol: told apart by most eyes, the first ones in grey too.
const COLOURS: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(213, 94, 0),
    RGBColor(240, 228, 66),
    RGBColor(110, 110, 110),
    RGBColor(51, 34, 136),
    RGBColor(153, 153, 51),
    RGBColor(136, 34, 85),
    RGBColor(187, 187, 187),
];
/// Of a front, behind its points.
const GREY: RGBColor = RGBColor(215, 215, 215);

/// A plot for the page.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(super) struct Plot {
    /// What it shows, with its units.
    pub(super) title: String,
    /// An `svg` element.
    pub(super) svg: String,
    /// Colours, as CSS has them, and what they stand for.
    pub(super) legend: Vec<[String; 2]>,
}

/// A bar of stacked parts, in the order of the legend.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bar {
    pub(super) label: String,
    pub(super) parts: Vec<f64>,
    /// A whisker.
    pub(super) range: Option<[f64; 2]>,
}

/// Points of one name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) points: Vec<[f64; 2]>,
}

fn colour(i: usize) -> RGBColor {
    COLOURS[i % COLOURS.len()]
}

fn legend<'n>(names: impl IntoIterator<Item = &'n String>) -> Vec<[String; 2]> {
    let css = |i| {
        let RGBColor(r, g, b) = colour(i);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    names.into_iter().enumerate().map(|(i, name)| [css(i), name.clone()]).collect()
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Charted<T> = std::result::Result<T, Box<dyn std::error::Error>>;
type Drawn = Charted<()>;

fn drawn(title: &str, height: u32, draw: impl FnOnce(&Area) -> Drawn) -> Result<String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
    let done = draw(&area).and_then(|()| Ok(area.present()?));
    drop(area);
    done.map_err(|e| ReportError::Plot { plot: title.to_owned(), why: e.to_string() })?;
    Ok(svg)
}

/// A label in as many characters as there is room for: what is too long loses its middle.
fn shortened(label: &str) -> String {
    let letters: Vec<char> = label.chars().collect();
    let (most, cut) = (LABEL.0, letters.len().saturating_sub(LABEL.0));
    if cut == 0 {
        return label.to_owned();
    }
    let (head, tail) = (&letters[..most / 3], &letters[most / 3 + cut + 1..]);
    head.iter().chain(&['…']).chain(tail).collect()
}

/// Bars one below another along an axis `unit` that begins at 0; `names` are those of their parts.
pub(super) fn bars(title: &str, unit: &str, names: &[String], bars: &[Bar]) -> Result<Plot> {
    let total = |b: &Bar| b.parts.iter().sum::<f64>();
    let end = |b: &Bar| b.range.map_or(0.0, |r| r[1]).max(total(b));
    let ends = bars.iter().map(end).filter(|x| *x < f64::MAX / 2.0);
    let most = ends.fold(f64::MIN_POSITIVE, f64::max) * 1.04;
    // A file may say any number, and pixels are counted by 32-bit integers.
    let on = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, most) };
    let rows = bars.len().max(1) as f64;
    let labels: Vec<String> = bars.iter().map(|bar| shortened(&bar.label)).collect();
    let letters = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    let svg = drawn(title, ROW * bars.len() as u32 + 64, |area| {
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .margin_right(30)
            .x_label_area_size(44)
            .y_label_area_size(letters as u32 * LABEL.1 + 12)
            .build_cartesian_2d(0.0..most, 0.0..rows)?;
        let mut mesh = chart.configure_mesh();
        mesh.disable_y_mesh().y_labels(0).light_line_style(TRANSPARENT);
        mesh.x_labels(6).x_desc(unit).label_style(FONT).axis_desc_style(FONT).draw()?;
        let right = TextStyle::from(FONT.into_font()).pos(Pos::new(HPos::Right, VPos::Center));
        let inset = f64::from(GAP) / f64::from(ROW) / 2.0;
        for (i, (bar, label)) in bars.iter().zip(labels).enumerate() {
            let (low, high) = (rows - i as f64 - 1.0 + inset, rows - i as f64 - inset);
            let mut x = 0.0;
            for (k, part) in bar.parts.iter().enumerate() {
                let corners = [(on(x), low), (on(x + part), high)];
                chart.draw_series([Rectangle::new(corners, colour(k).filled())])?;
                x += part;
            }
            let middle = (low + high) / 2.0;
            if let Some([from, to]) = bar.range.map(|r| r.map(on)) {
                let ends = [from, to].map(|x| PathElement::new([(x, low), (x, high)], BLACK));
                chart.draw_series(ends)?;
                chart.draw_series([PathElement::new([(from, middle), (to, middle)], BLACK)])?;
            }
            let label = EmptyElement::at((0.0, middle)) + Text::new(label, (-8, 0), right.clone());
            chart.plotting_area().draw(&label)?;
        }
        Ok(())
    })?;
    Ok(Plot { title: title.to_owned(), svg, legend: if names.len() > 1 { legend(names) } else { vec![] } })
}

/// Least and greatest coordinate `k` of all points that are above 0, a little apart.
fn range(series: &[Series], k: usize) -> [f64; 2] {
    let all = || series.iter().flat_map(|s| &s.points).map(|p| p[k]).filter(|x| *x > 0.0 && x.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    if low <= high { [low / 1.2, high * 1.2] } else { [0.1, 1.0] }
}

type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

/// An area with axes.
fn chart<'a, 'b, X, Y>(
    area: &Area<'b>,
    units: [&str; 2],
    x: X,
    y: Y,
) -> Charted<Chart<'a, 'b, X::CoordDescType, Y::CoordDescType>>
where
    X: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
    Y: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
{
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(30)
        .x_label_area_size(44)
        .y_label_area_size(72)
        .build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT).x_desc(units[0]).y_desc(units[1]);
    mesh.x_label_formatter(&number).y_label_formatter(&number);
    mesh.label_style(FONT).axis_desc_style(FONT).draw()?;
    Ok(chart)
}

/// A tick's number in few characters.
fn number(x: &f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e5 => format!("{}", (x * 1e4).round() / 1e4),
        _ => format!("{x:.0e}"),
    }
}

/// A logarithmic axis. Its ticks: decades, every few of them where they are many, shares of one where they are few.
fn logarithmic([low, high]: [f64; 2]) -> WithKeyPoints<LogCoord<f64>> {
    let [first, last] = [low.log10().floor() as i32, high.log10().ceil() as i32];
    let every = 1 + (last - first) as usize / 8;
    let ticks = |digits: &[f64], every| {
        let decade = |k: i32| digits.iter().map(move |d| d * 10f64.powi(k)).collect::<Vec<_>>();
        let all = (first..=last).step_by(every).flat_map(decade);
        all.filter(|x| (low..=high).contains(x)).collect::<Vec<f64>>()
    };
    let finer = [&[1.0][..], &[1.0, 3.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]];
    let found = finer.map(|digits| ticks(digits, every));
    let enough = found.iter().find(|t| t.len() >= 3).unwrap_or(&found[3]);
    (low..high).log_scale().with_key_points(enough.clone())
}

/// Curves over whole numbers from 0; the other axis is logarithmic, and what is not above 0 left out.
pub(super) fn curves(title: &str, units: [&str; 2], series: &[Series]) -> Result<Plot> {
    let [low, high] = range(series, 1);
    let most = series.iter().flat_map(|s| &s.points).map(|p| p[0]).fold(1.0, f64::max);
    let svg = drawn(title, 340, |area| {
        let mut chart = chart(area, units, 0.0..most, logarithmic([low, high]))?;
        for (i, s) in series.iter().enumerate() {
            let points = s.points.iter().filter(|p| p[1] > 0.0).map(|p| (p[0], p[1]));
            chart.draw_series(LineSeries::new(points, colour(i).stroke_width(2)))?;
        }
        Ok(())
    })?;
    Ok(Plot { title: title.to_owned(), svg, legend: legend(series.iter().map(|s| &s.name)) })
}

/// What else a plot of points shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lines {
    /// Nothing.
    None,
    /// The points that no other is better than in both coordinates, the less the better, joined in grey: a Pareto front.
    Front,
    /// The front, and each series' points joined as they come.
    FrontAndSeries,
}

/// Points, both axes logarithmic. What lies at 0 upward stands as a cross at the foot; what is not above 0 to the right is
/// left out.
pub(super) fn points(title: &str, units: [&str; 2], series: &[Series], lines: Lines) -> Result<Plot> {
    let [[left, right], [low, high]] = [0, 1].map(|k| range(series, k));
    let has_zero = series.iter().flat_map(|s| &s.points).any(|p| p[1] == 0.0);
    let foot = if has_zero { low / 4.0 } else { low };
    let placed = |p: &[f64; 2]| {
        let there = p[0] > 0.0 && p[0].is_finite() && p[1] >= 0.0 && p[1].is_finite();
        there.then(|| (p[0], if p[1] > 0.0 { p[1] } else { foot * 1.3 }))
    };
    let svg = drawn(title, 380, |area| {
        let mut chart = chart(area, units, logarithmic([left, right]), logarithmic([foot, high]))?;
        if lines != Lines::None {
            let all: Vec<[f64; 2]> = series.iter().flat_map(|s| &s.points).copied().collect();
            let front = front(&all);
            chart.draw_series(LineSeries::new(front.iter().filter_map(placed), GREY.stroke_width(6)))?;
        }
        for (i, s) in series.iter().enumerate() {
            if lines == Lines::FrontAndSeries {
                let joined = s.points.iter().filter_map(placed);
                chart.draw_series(LineSeries::new(joined, colour(i).stroke_width(2)))?;
            }
            let (found, none): (Vec<&[f64; 2]>, Vec<_>) = s.points.iter().partition(|p| p[1] > 0.0);
            let (found, none) = [found, none].map(|p| p.into_iter().filter_map(placed)).into();
            chart.draw_series(found.map(|at| Circle::new(at, 4, colour(i).filled())))?;
            chart.draw_series(none.map(|at| Cross::new(at, 5, colour(i).stroke_width(2))))?;
        }
        Ok(())
    })?;
    Ok(Plot { title: title.to_owned(), svg, legend: legend(series.iter().map(|s| &s.name)) })
}

/// Those of `points` that no other is as good as in both coordinates and better in one, less being better; by the first.
fn front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> =
        points.iter().filter(|p| p.iter().all(|x| x.is_finite())).copied().collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut front: Vec<[f64; 2]> = vec![];
    for p in sorted {
        if front.last().is_none_or(|last| p[1] < last[1]) {
            front.push(p);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_beats_the_front() {
        let points = [[3.0, 1.0], [1.0, 5.0], [2.0, 5.0], [2.0, 2.0], [1.0, 7.0], [4.0, 1.0], [5.0, 0.0]];
        assert_eq!(front(&points), [[1.0, 5.0], [2.0, 2.0], [3.0, 1.0], [5.0, 0.0]]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn axes_have_few_ticks_in_few_characters() {
        for (low, high) in [(1.0, 2.0), (0.9, 11.0), (3.0, 900.0), (1e-8, 1e-6), (1e-9, 1e9), (40.0, 41.0)] {
            let axis = logarithmic([low, high]);
            let n = axis.bold_points().len();
            assert!((if high / low > 1.3 { 2 } else { 0 }..=10).contains(&n), "{low} to {high}: {n}");
        }
        let texts = [0.0, 0.05, 1.5, 20.0, 3e4, 1e6, 4e-8].map(|x| number(&x));
        assert_eq!(texts, ["0", "0.05", "1.5", "20", "30000", "1e6", "4e-8"]);
    }

    #[test]
    fn zeros_are_crosses_at_the_foot() {
        let named = |points: &[[f64; 2]]| [Series { name: "a".into(), points: points.to_vec() }];
        let plot = |p: &[[f64; 2]]| points("t", ["x", "y"], &named(p), Lines::Front).map(|plot| plot.svg);
        let [with, without] = [plot(&[[1.0, 0.0], [2.0, 3.0]]), plot(&[[1.0, 2.0], [2.0, 3.0]])];
        let circles = |svg: &Result<String>| svg.as_ref().map_or(0, |s| s.matches("<circle").count());
        assert_eq!((circles(&with), circles(&without)), (1, 2));
        assert!(plot(&[]).is_ok() && plot(&[[0.0, 0.0]]).is_ok());
    }
}
