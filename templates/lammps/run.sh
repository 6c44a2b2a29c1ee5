#!/bin/sh
# Runs this deck in its own folder. RIPRAP_LAMMPS names another program.
cd "$(dirname "$0")" || exit 1
export OMP_NUM_THREADS=1
{%- if springs %}
# A first start writes the restart file whose contacts springs.py gives their springs.
export OMPI_MCA_ess_singleton_isolated=1
rm -f start.restart springs.restart
"${RIPRAP_LAMMPS:-lmp}" -in in.lammps -log none || exit 1
python3 springs.py || exit 1
unset OMPI_MCA_ess_singleton_isolated
set -- -var springs 1 "$@"
{%- endif %}
{%- if ranks > 1 %}
root=
[ "$(id -u)" = 0 ] && root=--allow-run-as-root
exec mpirun $root --oversubscribe -np {{ ranks }} "${RIPRAP_LAMMPS:-lmp}" -in in.lammps -log log.lammps "$@"
{%- else %}
# One process needs no Open MPI daemon: half the time to start.
export OMPI_MCA_ess_singleton_isolated=1
exec "${RIPRAP_LAMMPS:-lmp}" -in in.lammps -log log.lammps "$@"
{%- endif %}
