//! Events that share an instant, and their order.

mod at_one_instant;
mod crossings_at_jumps;
mod independent;
mod joint_chatter;
mod meeting;
mod order_of_events;
mod together;
