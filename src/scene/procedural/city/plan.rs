//! What stands on a plot of the city: streets on two sides, then a house, a tower or a park on rolling ground.

use crate::scene::procedural::noise::{h32, u01, value2};

/// Cells along a plot's side.
pub(super) const PLOT: usize = 20;
/// Width of the streets along a plot's low x and low z.
const STREET: usize = 4;
/// Height of a storey with its floor.
const STOREY: u32 = 4;
/// Cells from the ground's lowest to the roof of the highest tower: ground 30, 12 storeys, a parapet.
pub(super) const COLUMN_BITS: u32 = 30 + 12 * STOREY + 18;
const SEED: u32 = 0xC117;

/// Columns of a plot, by z, then x.
pub(super) type Plot = [[u128; PLOT]; PLOT];

/// The plot (px, pz), a function of those alone.
pub(super) fn plot(px: u32, pz: u32) -> Plot {
    let mut ground = [[0u32; PLOT]; PLOT];
    for (z, row) in ground.iter_mut().enumerate() {
        for (x, height) in row.iter_mut().enumerate() {
            let (x, z) = (f64::from(px) * PLOT as f64 + x as f64, f64::from(pz) * PLOT as f64 + z as f64);
            let hills = 14.0 * value2(x / 64.0, z / 64.0, SEED) + 6.0 * value2(x / 16.0, z / 16.0, SEED + 1);
            *height = 10 + hills as u32;
        }
    }
    let level = ground.iter().flatten().copied().max().unwrap_or(10);
    let mut plot = ground.map(|row| row.map(below));
    for (z, row) in plot.iter_mut().enumerate() {
        for (x, column) in row.iter_mut().enumerate() {
            if x < STREET || z < STREET {
                *column = below(level);
            }
        }
    }
    let dice = |k: u32| h32(px, pz, SEED + 2 + k);
    match dice(0) % 100 {
        0..66 => House::new(&dice, level, 2 + dice(1) % 4).build(&mut plot, Roof::Gable, &dice),
        66..78 => House::new(&dice, level, 6 + dice(1) % 7).build(&mut plot, Roof::Flat, &dice),
        _ => park(&mut plot, &ground, px, pz),
    }
    plot
}

/// All cubes below height `y`.
fn below(y: u32) -> u128 {
    (1u128 << y) - 1
}

enum Roof {
    Gable,
    Flat,
}

/// A building's box: low corner in the plot, size, lowest floor, storeys.
struct House {
    x: usize,
    z: usize,
    width: usize,
    depth: usize,
    level: u32,
    storeys: u32,
}

impl House {
    fn new(dice: &impl Fn(u32) -> u32, level: u32, storeys: u32) -> Self {
        // One cell is left on every side for the eaves.
        let room = PLOT - STREET;
        let (width, depth) = (9 + dice(2) as usize % 6, 9 + dice(3) as usize % 6);
        let x = STREET + 1 + dice(4) as usize % (room - 1 - width);
        let z = STREET + 1 + dice(5) as usize % (room - 1 - depth);
        Self { x, z, width, depth, level, storeys }
    }

    fn build(&self, plot: &mut Plot, roof: Roof, dice: &impl Fn(u32) -> u32) {
        let top = self.level + self.storeys * STOREY;
        for lz in 0..self.depth {
            for lx in 0..self.width {
                plot[self.z + lz][self.x + lx] = below(self.level) | self.column(lx, lz) | 1 << top;
            }
        }
        for storey in 0..self.storeys {
            for k in 0..6 {
                let roll = dice(16 + 6 * storey + k);
                let x = self.x + 1 + roll as usize % (self.width - 2);
                let z = self.z + 1 + (roll >> 16) as usize % (self.depth - 2);
                plot[z][x] |= 1 << (self.level + storey * STOREY + 1);
            }
        }
        match roof {
            Roof::Flat => {
                for lz in 0..self.depth {
                    for lx in (0..self.width).filter(|&lx| self.on_wall(lx, lz)) {
                        plot[self.z + lz][self.x + lx] |= 1 << (top + 1);
                    }
                }
            }
            Roof::Gable => self.gable(plot, top),
        }
    }

    fn on_wall(&self, lx: usize, lz: usize) -> bool {
        lx == 0 || lz == 0 || lx == self.width - 1 || lz == self.depth - 1
    }

    /// Floors, outer walls with windows, an inner wall with a door on each storey.
    fn column(&self, lx: usize, lz: usize) -> u128 {
        let along_x = lz == 0 || lz == self.depth - 1;
        let along_z = lx == 0 || lx == self.width - 1;
        let window = match (along_x, along_z) {
            (true, false) => lx % 3 == 2,
            (false, true) => lz % 3 == 2,
            _ => false,
        };
        let inner = lx == self.width / 2;
        let storey: u128 = match (along_x || along_z, window) {
            (true, true) => 0b1011,
            (true, false) => 0b1111,
            (false, _) if inner && lz == self.depth / 2 => 0b1001,
            (false, _) if inner => 0b1111,
            (false, _) => 0b0001,
        };
        (0..self.storeys).fold(0, |c, s| c | storey << (self.level + s * STOREY))
    }

    /// A stepped roof, one cube thick, that overhangs by one; its ends are walled up.
    fn gable(&self, plot: &mut Plot, top: u32) {
        for step_z in 0..self.depth + 2 {
            for step_x in 0..self.width + 2 {
                let (z, x) = (self.z + step_z - 1, self.x + step_x - 1);
                let rise = step_x.min(self.width + 1 - step_x) as u32;
                let column = &mut plot[z][x];
                *column |= 1 << (top + rise);
                if (step_z == 1 || step_z == self.depth) && rise > 0 {
                    *column |= below(top + rise) & !below(top);
                }
            }
        }
    }
}

/// Nine trees: a trunk, and a ball of 5 × 5 × 4 leaves of which 62 % are there.
fn park(plot: &mut Plot, ground: &[[u32; PLOT]; PLOT], px: u32, pz: u32) {
    for tree in 0..9u32 {
        let roll = h32(h32(px, pz, SEED + 200), tree, SEED + 201);
        let x = STREET + 2 + 5 * (tree as usize % 3) + (roll & 1) as usize;
        let z = STREET + 2 + 5 * (tree as usize / 3) + (roll >> 1 & 1) as usize;
        let foot = ground[z][x];
        for dz in 0..5usize {
            for dx in 0..5usize {
                for dy in 0..4u32 {
                    let cell = (dz * 5 + dx) as u32 * 4 + dy;
                    if u01(roll, cell, SEED + 202) < 0.62 {
                        plot[z + dz - 2][x + dx - 2] |= 1 << (foot + 3 + dy);
                    }
                }
            }
        }
        plot[z][x] |= below(foot + 5) & !below(foot);
    }
}
