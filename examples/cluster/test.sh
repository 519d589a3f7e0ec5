#!/usr/bin/env bash
# Runs slurm.sh on a small diagram and compares with one run. chatter has to be on the path; SLURM=yes uses the real sbatch.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
if [ "${SLURM:-no}" != yes ]; then
    mkdir bin
    # Runs what is queued at once, each task of an array in turn.
    cat > bin/sbatch <<'STUB'
#!/usr/bin/env bash
set -euo pipefail
tasks=0
while [ $# -gt 0 ]; do
    case $1 in
        --array=1-*) tasks=${1#--array=1-} ;;
        --wrap) wrapped=$2; shift ;;
    esac
    shift
done
if [ "$tasks" -gt 0 ]; then
    for task in $(seq "$tasks"); do SLURM_ARRAY_TASK_ID=$task bash -c "$wrapped" >&2; done
else
    bash -c "$wrapped" >&2
fi
echo 17
STUB
    chmod +x bin/sbatch
    PATH=$folder/bin:$PATH
fi
asked=(pressure_relief_valve --sweep q=0.0201:0.0225:40 --observe y2 --transient 20 --keep 10 --start carry --chunk 4)
"$here/slurm.sh" 3 parts.npz "${asked[@]}"
while ! [ -e parts.npz ]; do sleep 1; done
chatter diagram "${asked[@]}" --out whole.npz
cmp whole.npz parts.npz && echo "the same to the bit"
