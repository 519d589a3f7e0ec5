//! What the walk along one side of a branch came to, as it is kept: another walk goes on from there, to the same bits.

use crate::analysis::continuation::Station;
use crate::analysis::periodic::branch::special::Seed;
use crate::analysis::periodic::branch::{End, Point, Special};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::shooting::{Shooting, Workshop};
use crate::expressions::Sides;
use crate::flow::{Grip, System};
use crate::numerics::stored::{list, number};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A part of a branch that was followed: what came about since the record before it on the same side, and how it goes on. Records
/// of one survey belong in the order in which they were told.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// What the modes that are mentioned are: their numbers are not the same in every run.
    modes: Vec<(Grip, Sides)>,
    points: Vec<Point>,
    special: Vec<(Special, Option<Equations>)>,
    then: Then,
}

impl Record {
    /// In which form records are kept.
    pub const FORMAT: u32 = 7;

    /// How many orbits it adds.
    pub fn orbits(&self) -> usize {
        self.points.len()
    }
}

/// How a side goes on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::analysis::periodic) enum Then {
    On(Box<Standing>),
    /// From its latest points, which say all.
    Points,
    Ended(End),
}

/// The equations of an orbit, and a solution.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Equations {
    steps: Vec<Step>,
    counts: Vec<i64>,
    #[serde(with = "list")]
    scales: Vec<f64>,
    #[serde(with = "list")]
    pins: Vec<f64>,
    told: Option<Vec<f64>>,
    /// Normals of the planes that steps lead around to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    planes: Vec<Vec<f64>>,
    #[serde(with = "list")]
    at: Vec<f64>,
}

/// All that a walk knows between two of its steps.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::analysis::periodic) struct Standing {
    equations: Equations,
    #[serde(with = "list")]
    tangent: Vec<f64>,
    /// Residual, correction and orientation of the station, and the next step.
    #[serde(with = "list")]
    numbers: Vec<f64>,
    here: Point,
    made: usize,
    of: Of,
}

/// What is followed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::analysis::periodic) enum Of {
    Branch(Walked),
    Curve(Along),
}

/// What a walk along a curve in two parameters remembers of its way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::analysis::periodic) struct Along {
    /// The borders of the matrix that is singular along it.
    #[serde(with = "list")]
    pub borders: Vec<f64>,
    /// The parameters where the sequence of events changed last, and how many points there were beyond that.
    pub passed: Option<(Vec<f64>, usize)>,
}

/// What a walk along a branch remembers of its way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::analysis::periodic) struct Walked {
    /// Where it began: nodes and times, and the sequence of events.
    #[serde(with = "list")]
    pub origin: Vec<f64>,
    pub passages: Vec<Passage>,
    /// Whether the parameter grew from there.
    pub rises: bool,
    pub grazes: usize,
    /// How often it went on past its equations with no step of note since.
    pub hops: usize,
    /// What was gone since a point was kept.
    #[serde(with = "number")]
    pub since_kept: f64,
}

/// Where a walk stands.
#[derive(Clone, Debug)]
pub(in crate::analysis::periodic) struct Stand {
    pub station: Station,
    /// The next step.
    pub step: f64,
    pub here: Point,
    pub made: usize,
    pub of: Of,
}

impl Equations {
    fn of(shooting: &Shooting<f64>, at: &[f64]) -> Self {
        Self {
            steps: shooting.steps.clone(),
            counts: shooting.counts.clone(),
            scales: shooting.scales.clone(),
            pins: shooting.pins.clone(),
            told: shooting.told.clone(),
            planes: shooting.planes.clone(),
            at: at.to_vec(),
        }
    }

    fn restored(self, workshop: &Arc<Workshop>) -> Result<Seed, PeriodicError> {
        let mut shooting = Shooting::new(workshop, self.steps, self.counts)?;
        if [self.scales.len(), self.at.len()] != [shooting.scales.len(); 2] {
            return Err(damaged());
        }
        shooting.scales = self.scales;
        shooting.pins = self.pins;
        shooting.told = self.told;
        shooting.planes = self.planes;
        Ok(Seed {
            shooting,
            at: self.at,
        })
    }
}

pub(in crate::analysis::periodic) fn damaged() -> PeriodicError {
    PeriodicError::Unfollowed {
        what: "a record that is not of this branch".to_owned(),
    }
}

/// The mode of a passage.
fn mode(passage: &mut Passage) -> &mut usize {
    match passage {
        Passage::Leg(kind)
        | Passage::Timed(kind)
        | Passage::Around(kind)
        | Passage::AtOnce(kind)
        | Passage::Together(kind) => &mut kind.mode,
        Passage::Stretch(kind) => &mut kind.last.mode,
    }
}

impl Record {
    /// Of the latest part of a side. Without a system: one that has no equations.
    pub(super) fn new(
        system: Option<&System>,
        (points, special): (&[Point], &[Special]),
        then: Then,
    ) -> Self {
        let with_equations = |special: &Special| {
            let seed = special.seed.as_ref();
            let equations = seed.map(|seed| Equations::of(&seed.shooting, &seed.at));
            (special.clone(), equations)
        };
        let mut record = Self {
            modes: Vec::new(),
            points: points.to_vec(),
            special: special.iter().map(with_equations).collect(),
            then,
        };
        let mut met: Vec<usize> = Vec::new();
        record.each_mode(&mut |mode| {
            let place = met.iter().position(|known| known == mode);
            *mode = place.unwrap_or_else(|| {
                met.push(*mode);
                met.len() - 1
            });
        });
        let of = |mode: usize| {
            let origin = system.and_then(|system| system.origin_of(mode));
            origin.map_or_else(Default::default, |(grip, sides, _)| (grip, sides))
        };
        record.modes = met.into_iter().map(of).collect();
        record
    }

    fn each_mode(&mut self, change: &mut dyn FnMut(&mut usize)) {
        let equations = self.special.iter_mut().filter_map(|(_, at)| at.as_mut());
        for step in equations.flat_map(|equations| &mut equations.steps) {
            change(mode(&mut step.passage));
        }
        if let Then::On(standing) = &mut self.then {
            for step in &mut standing.equations.steps {
                change(mode(&mut step.passage));
            }
            if let Of::Branch(walked) = &mut standing.of {
                for passage in &mut walked.passages {
                    change(mode(passage));
                }
            }
        }
    }

    /// What was found, and how it goes on: with the modes of this system. Without one: of a side that has no equations.
    pub(super) fn restored(
        mut self,
        workshop: Option<&Arc<Workshop>>,
    ) -> Result<(Vec<Point>, Vec<Special>, Then), PeriodicError> {
        let Some(workshop) = workshop else {
            let (special, none): (Vec<_>, Vec<_>) = self.special.into_iter().unzip();
            return match none.iter().any(Option::is_some) {
                true => Err(damaged()),
                false => Ok((self.points, special, self.then)),
            };
        };
        let meet = |&(grip, sides): &(Grip, Sides)| workshop.system.meet(grip, sides);
        let numbers: Vec<usize> = self.modes.iter().map(meet).collect();
        let mut known = true;
        self.each_mode(&mut |mode| match numbers.get(*mode) {
            Some(number) => *mode = *number,
            None => known = false,
        });
        if !known {
            return Err(damaged());
        }
        let mut special = Vec::with_capacity(self.special.len());
        for (mut point, equations) in self.special {
            if let Some(equations) = equations {
                point.seed = Some(equations.restored(workshop)?);
            }
            special.push(point);
        }
        Ok((self.points, special, self.then))
    }
}

impl Standing {
    pub(in crate::analysis::periodic) fn of(shooting: &Shooting<f64>, stand: &Stand) -> Self {
        let Station {
            at,
            tangent,
            residual,
            correction,
            orientation,
        } = &stand.station;
        Self {
            equations: Equations::of(shooting, at),
            tangent: tangent.clone(),
            numbers: vec![*residual, *correction, *orientation, stand.step],
            here: stand.here.clone(),
            made: stand.made,
            of: stand.of.clone(),
        }
    }

    /// Equations and place.
    pub(in crate::analysis::periodic) fn restored(
        self,
        workshop: &Arc<Workshop>,
    ) -> Result<(Shooting<f64>, Stand), PeriodicError> {
        let Seed { shooting, at } = self.equations.restored(workshop)?;
        let &[residual, correction, orientation, step] = &*self.numbers else {
            return Err(damaged());
        };
        if self.tangent.len() != at.len() {
            return Err(damaged());
        }
        let stand = Stand {
            station: Station {
                at,
                tangent: self.tangent,
                residual,
                correction,
                orientation,
            },
            step,
            here: self.here,
            made: self.made,
            of: self.of,
        };
        Ok((shooting, stand))
    }
}
