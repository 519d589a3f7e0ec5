//! Questions asked of the flow: border orbits, periodic orbits and their branches. One program, since each would compile the
//! flow anew.

mod borders;
mod exponents;
mod periodic;
mod settling;
