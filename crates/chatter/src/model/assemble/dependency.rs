//! An order in which quantities that use each other can be computed.

use crate::expressions::Symbol;
use crate::model::Model;

/// All of `0..count`, each after those it uses; or a circle among them, whose last is its first.
pub(in crate::model) fn dependency_order(uses: &[Vec<usize>]) -> Result<Vec<usize>, Vec<usize>> {
    let mut state = vec![Visit::New; uses.len()];
    let mut order = Vec::with_capacity(uses.len());
    // The path walked so far: each is used by the one before, with the number of its own uses already seen to.
    let mut path: Vec<(usize, usize)> = Vec::new();
    for start in 0..uses.len() {
        if state[start] == Visit::New {
            state[start] = Visit::Open;
            path.push((start, 0));
        }
        while let Some((node, seen)) = path.last_mut() {
            let Some(&used) = uses[*node].get(*seen) else {
                state[*node] = Visit::Done;
                order.push(*node);
                path.pop();
                continue;
            };
            *seen += 1;
            match state[used] {
                Visit::Done => {}
                Visit::New => {
                    state[used] = Visit::Open;
                    path.push((used, 0));
                }
                Visit::Open => {
                    let circle = path
                        .iter()
                        .map(|&(node, _)| node)
                        .skip_while(|&node| node != used);
                    return Err(circle.chain([used]).collect());
                }
            }
        }
    }
    Ok(order)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    New,
    Open,
    Done,
}

impl Model {
    /// The parameters, each after those its value uses; or a circle among them.
    pub(in crate::model) fn parameter_order(&self) -> Result<Vec<usize>, Vec<usize>> {
        let used = |symbol| match symbol {
            Symbol::Parameter(index) => (index < self.parameters.len()).then_some(index),
            Symbol::State(_) => None,
        };
        let uses: Vec<Vec<usize>> = (self.parameters.iter())
            .map(|parameter| {
                self.graph
                    .symbols(parameter.value)
                    .into_iter()
                    .filter_map(used)
                    .collect()
            })
            .collect();
        dependency_order(&uses)
    }
}

#[cfg(test)]
mod tests {
    use super::dependency_order;

    #[test]
    fn each_comes_after_what_it_uses() {
        let order = dependency_order(&[vec![2], vec![0, 2], vec![3], vec![]]).unwrap();
        assert_eq!(order, [3, 2, 0, 1]);
    }

    #[test]
    fn a_circle_is_named_from_where_it_closes() {
        assert_eq!(
            dependency_order(&[vec![1], vec![2], vec![1]]),
            Err(vec![1, 2, 1])
        );
        assert_eq!(dependency_order(&[vec![0]]), Err(vec![0, 0]));
    }

    #[test]
    fn long_chains_need_no_stack() {
        let uses: Vec<Vec<usize>> = (0..200_000)
            .map(|k| if k == 199_999 { vec![] } else { vec![k + 1] })
            .collect();
        assert_eq!(dependency_order(&uses).unwrap()[0], 199_999);
    }
}
