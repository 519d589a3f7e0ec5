//! What closes, stays closed and opens.

mod after_release;
mod chatter_limits;
mod collapse;
mod grazes;
mod held_by_friction;
mod higher_orders;
mod kinks;
mod moved_gaps;
mod nested_chatter;
mod painleve;
mod several_contacts;
mod several_releases;
mod standing;
mod thrown_together;
mod waves;
