#!/bin/sh
# Runs this deck in its own folder. RIPRAP_LIGGGHTS names another program.
cd "$(dirname "$0")" || exit 1
# Unbuffered: LIGGGHTS loses its error messages when its output is a pipe.
unbuffered=
command -v stdbuf >/dev/null && unbuffered="stdbuf -o0"
{%- if restarts %}
# --resume: goes on from the newest restart file, and from the start where there is none.
if [ "$1" = --resume ]; then
  shift
  newest=$(ls restart.* 2>/dev/null | sed 's/restart\.//' | sort -n | tail -n 1)
  set -- -var resume "${newest:-0}" "$@"
fi
{%- endif %}
{%- if springs %}
# A first start writes the restart file whose contacts springs.py gives their springs.
export OMPI_MCA_ess_singleton_isolated=1
rm -f start.restart springs.restart
# (`quit` of LIGGGHTS ends with status 1.)
$unbuffered "${RIPRAP_LIGGGHTS:-liggghts}" -in in.liggghts -log none
[ -s start.restart ] || exit 1
python3 springs.py || exit 1
unset OMPI_MCA_ess_singleton_isolated
set -- -var springs 1 "$@"
{%- endif %}
{%- if ranks > 1 %}
root=
[ "$(id -u)" = 0 ] && root=--allow-run-as-root
exec mpirun $root --oversubscribe -np {{ ranks }} $unbuffered "${RIPRAP_LIGGGHTS:-liggghts}" -in in.liggghts "$@"
{%- else %}
# One process needs no Open MPI daemon: half the time to start.
export OMPI_MCA_ess_singleton_isolated=1
exec $unbuffered "${RIPRAP_LIGGGHTS:-liggghts}" -in in.liggghts "$@"
{%- endif %}
