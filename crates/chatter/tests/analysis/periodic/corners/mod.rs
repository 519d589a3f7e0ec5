//! Corners and surfaces that orbits meet, touch and slide along.

mod asked;
mod at_touches;
mod border_collisions;
mod corners_at_sections;
mod edges;
mod event_touches;
mod impacts_at_corners;
mod one_way;
mod rough_walls;
mod sticks;
mod struck_sliders;
mod surfaces;
pub(super) mod touches;
mod turns_at_release;
mod turns_in_flight;
