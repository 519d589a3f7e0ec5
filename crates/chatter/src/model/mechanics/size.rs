//! Models too large to be derived and compiled are refused, before they cost time and memory.

use super::MechanicsError;
use crate::expressions::{Expr, Graph, Node, Symbol};

/// Operations that the derivatives of products may take: the derivative of a product of n factors that change is a sum of n
/// products of n factors. As many as 512 factors give, which fill a hundred megabytes with their expansions.
const MOST_PRODUCT_OPERATIONS: usize = 1 << 18;

/// Deepest nesting of expressions, definitions written out: compiling needs some two kilobytes of the stack for each.
const DEEPEST: usize = 1000;

/// Whether the expressions that a model is made of are small enough.
pub(in crate::model) fn check_size(graph: &Graph, roots: &[Expr]) -> Result<(), MechanicsError> {
    let parts = graph.reachable(roots);
    let size = parts.last().map_or(0, |last| last.index() + 1);
    let mut depth = vec![0_usize; size];
    let mut changes = vec![false; size];
    let mut operations: usize = 0;
    for part in parts {
        let (mut deepest, mut changing) = (0, 0);
        graph.for_each_operand(part, |operand| {
            deepest = deepest.max(depth[operand.index()]);
            changing += usize::from(changes[operand.index()]);
        });
        depth[part.index()] = deepest + 1;
        changes[part.index()] =
            changing > 0 || matches!(graph.node(part), Node::Symbol(Symbol::State(_)));
        if matches!(graph.node(part), Node::Product(_)) {
            operations = operations.saturating_add(changing.saturating_mul(changing));
        }
    }
    if let Some(&depth) = depth.iter().max().filter(|&&depth| depth > DEEPEST) {
        let most = DEEPEST;
        return Err(MechanicsError::TooDeep { depth, most });
    }
    if operations > MOST_PRODUCT_OPERATIONS {
        let most = MOST_PRODUCT_OPERATIONS;
        return Err(MechanicsError::TooManyFactors { operations, most });
    }
    Ok(())
}
