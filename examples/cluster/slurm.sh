#!/usr/bin/env bash
# Queues an orbit diagram as a job array, and its merge: slurm.sh SHARES OUT.npz MODEL [OPTION …]
set -euo pipefail
if [ $# -lt 3 ]; then
    echo "usage: $0 SHARES OUT.npz MODEL [OPTION ...]" >&2
    exit 2
fi
shares=$1 out=$2
shift 2
# Quoted for the shell that runs the job.
asked=$(printf ' %q' "$@")
array=$(sbatch --parsable --array="1-$shares" --job-name="${out##*/}" --requeue \
    --wrap "chatter diagram$asked --out $(printf %q "$out") --threads \${SLURM_CPUS_ON_NODE:-1} --shard \$SLURM_ARRAY_TASK_ID/$shares")
sbatch --parsable --dependency="afterany:${array%%;*}" --job-name="${out##*/}-merge" \
    --wrap "chatter merge $(printf %q "${out%.*}").*-of-$shares.journal --out $(printf %q "$out")"
