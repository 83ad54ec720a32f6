// Workgroups of an indirect dispatch over items of which a workgroup takes a tile: as Recorder::dispatch shapes a grid.
uvec3 dispatch_over(uint items, uint tile) {
    uint groups = (items + tile - 1) / tile;
    return groups == 0 ? uvec3(0) : uvec3(min(groups, GRID_WIDTH), (groups + GRID_WIDTH - 1) / GRID_WIDTH, 1);
}
