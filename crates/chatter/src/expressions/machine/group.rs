//! Numbers in groups of registers: as many as those of a chunk fill, and every operation on one after the other.

use super::assembler::{At, Source, Vector};
use super::compile::Compiler;

/// A group of registers, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Group(pub usize);

/// Where a number is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Group(Group),
    Memory(At),
}

impl From<Group> for Place {
    fn from(group: Group) -> Self {
        Self::Group(group)
    }
}

impl From<At> for Place {
    fn from(at: At) -> Self {
        Self::Memory(at)
    }
}

impl Compiler<'_> {
    fn register(&self, Group(number): Group, part: usize) -> Vector {
        Vector(number * self.registers + part)
    }

    fn source(&self, place: Place, part: usize) -> Source {
        match place {
            Place::Group(group) => self.register(group, part).into(),
            Place::Memory(at) => self.part(at, part).into(),
        }
    }

    /// `into = first + second`.
    pub(super) fn add(&mut self, into: Group, first: Group, second: Group) {
        for part in self.parts() {
            let [into, first, second] = [into, first, second].map(|g| self.register(g, part));
            self.code.add(into, first, second);
        }
    }

    /// `into = first * second`.
    pub(super) fn multiply(&mut self, into: Group, first: Group, second: impl Into<Place>) {
        let second = second.into();
        for part in self.parts() {
            let [into, first] = [into, first].map(|group| self.register(group, part));
            self.code.multiply(into, first, self.source(second, part));
        }
    }

    /// `sum += first * second`, rounded once.
    pub(super) fn multiply_add(&mut self, sum: Group, first: Group, second: impl Into<Place>) {
        let second = second.into();
        for part in self.parts() {
            let [sum, first] = [sum, first].map(|group| self.register(group, part));
            (self.code).multiply_add(sum, first, self.source(second, part));
        }
    }

    /// `into = into * first - second`, rounded once.
    pub(super) fn multiply_subtract(&mut self, into: Group, first: Group, second: Group) {
        for part in self.parts() {
            let [into, first, second] = [into, first, second].map(|g| self.register(g, part));
            self.code.multiply_subtract(into, first, second);
        }
    }

    pub(super) fn zero(&mut self, into: Group) {
        for part in self.parts() {
            self.code.zero(self.register(into, part));
        }
    }

    pub(super) fn negate(&mut self, group: Group) {
        for part in self.parts() {
            (self.code).negate(self.register(group, part), Self::minus_zero());
        }
    }

    pub(super) fn copy(&mut self, into: Group, from: Group) {
        for part in self.parts() {
            let [into, from] = [into, from].map(|group| self.register(group, part));
            self.code.copy(into, from);
        }
    }

    pub(super) fn load(&mut self, into: Group, at: At) {
        for part in self.parts() {
            (self.code).load(self.register(into, part), self.part(at, part));
        }
    }

    /// The double at `at`, in every lane.
    pub(super) fn broadcast(&mut self, into: Group, at: At) {
        for part in self.parts() {
            self.code.broadcast(self.register(into, part), at);
        }
    }

    pub(super) fn store(&mut self, at: At, from: Group) {
        for part in self.parts() {
            (self.code).store(self.part(at, part), self.register(from, part));
        }
    }
}
