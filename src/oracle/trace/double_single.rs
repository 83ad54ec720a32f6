//! Twin of `glsl/lib/double_single.glsl`: numbers of two floats \[DEKKER71\].

/// hi + lo.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    pub hi: f32,
    pub lo: f32,
}

impl Pair {
    pub fn new(hi: f32) -> Self {
        Self { hi, lo: 0.0 }
    }

    /// a + b.
    pub fn exact_sum(a: f32, b: f32) -> Self {
        let sum = a + b;
        let share = sum - a;
        Self { hi: sum, lo: (a - (sum - share)) + (b - share) }
    }

    /// a · b.
    pub fn exact_product(a: f32, b: f32) -> Self {
        let upper = |x: f32| {
            let wide = x * 4097.0;
            wide - (wide - x)
        };
        let (hi, [x, y]) = (a * b, [a, b].map(upper));
        let [below_x, below_y] = [a - x, b - y];
        Self { hi, lo: ((x * y - hi) + x * below_y + below_x * y) + below_x * below_y }
    }

    fn normalized(a: f32, b: f32) -> Self {
        let hi = a + b;
        Self { hi, lo: b - (hi - a) }
    }

    pub fn plus(self, other: Self) -> Self {
        let s = Self::exact_sum(self.hi, other.hi);
        Self::normalized(s.hi, s.lo + (self.lo + other.lo))
    }

    pub fn times(self, other: Self) -> Self {
        let p = Self::exact_product(self.hi, other.hi);
        Self::normalized(p.hi, p.lo + (self.hi * other.lo + self.lo * other.hi))
    }

    pub fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// The quotient, less than an ulp off.
    pub fn over(self, other: Self) -> f32 {
        let rough = self.hi / other.hi;
        let back = Self::exact_product(rough, other.hi);
        let rest = (self.hi - back.hi) - back.lo + (self.lo - rough * other.lo);
        rough + rest / other.hi
    }

    #[cfg(test)]
    pub fn to_f64(self) -> f64 {
        f64::from(self.hi) + f64::from(self.lo)
    }
}

/// p − o.
pub fn difference(p: [f32; 3], o: [f32; 3]) -> [Pair; 3] {
    std::array::from_fn(|k| Pair::exact_sum(p[k], -o[k]))
}

/// a × b.
pub fn cross(a: &[Pair; 3], b: &[Pair; 3]) -> [Pair; 3] {
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]: [usize; 2]| a[i].times(b[j]).plus(a[j].times(b[i]).negated()))
}

/// a · b.
pub fn dot(a: &[Pair; 3], b: &[Pair; 3]) -> Pair {
    a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
}

/// |a| ⊗ |b|, of single precision.
pub fn outer_size(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    let [a, b] = [a, b].map(|v| v.map(f32::abs));
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]: [usize; 2]| a[i] * b[j] + a[j] * b[i])
}

/// |a|·|b|, likewise.
pub fn inner_size(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| a[k].abs() * b[k].abs());
    x + (y + z)
}

/// The upper parts.
pub fn upper(v: &[Pair; 3]) -> [f32; 3] {
    v.map(|x| x.hi)
}
