// Boxes: common ones and their areas.

Aabb merged(Aabb a, Aabb b) {
    Aabb r;
    for (int k = 0; k < 3; ++k) {
        r.lo[k] = least_of(a.lo[k], b.lo[k]);
        r.hi[k] = greatest_of(a.hi[k], b.hi[k]);
    }
    return r;
}

// Half the surface area, from correctly rounded operations in one order: the same bits everywhere.
float half_area(Aabb box) {
    precise float x = box.hi.x - box.lo.x, y = box.hi.y - box.lo.y, z = box.hi.z - box.lo.z;
    precise float area = x * (y + z) + y * z;
    return area;
}
