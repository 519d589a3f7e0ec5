//! Questions asked of a flow or a map, one file each.
