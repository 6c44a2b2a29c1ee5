{% include "header.txt" -%}
#
# Contact law: ViscElMat, Law2_ScGeom_ViscElPhys_Basic; n from body 1 to body 2:
#   Fn = max(0, kn*overlap{% if needs.normal_damping %} + cn*vn{% endif %})
{%- if needs.friction %}
#   spring s turned with the contact to first order, then s += kt*dt*vt;
#   |s| > mu*Fn: Ft = s cut to mu*Fn{% if needs.tangential_damping %}, no dashpot{% endif %}
#   else         Ft = s{% if needs.tangential_damping %} + ct*vt (the dashpot is not cut){% endif %}
{%- else %}
#   no tangential force
{%- endif %}
# YADE puts two materials in series, 1/(1/a1 + 1/a2): the values below are such
# that every pair that can meet has the value of the scene.
# Scheme: forces at x(t) with v(t - dt/2). Velocities are given, and written, half a
# step before positions{% if needs.gravity %}: at the start v(0) - dt/2 g{% endif %}; angular velocities are given as they
# are. Contact forces at time 0 are not in the half step: best start without contacts.
# Run with: sh run.sh   (writes frames.txt, contacts.txt)
{% include "left_out.txt" %}
{% if many_frictions or oscillating -%}
import math
{% endif -%}
{% if needs.restarts %}import glob
{% endif %}import resource
{% if needs.restarts %}import sys
{% endif %}import time


def table(name):
    """Rows of numbers of a file; every double is read with all its digits."""
    with open(name) as lines:
        return [[float(word) for word in line.split(',')] for line in lines if line[0] != '#']


# Materials; friction angles in radians.
materials = [
{%- for m in materials %}
    O.materials.append(ViscElMat(density={{ m.density }}, kn={{ m.kn }}, cn={{ m.cn }}, ks={{ m.ks }}, cs={{ m.cs }}, frictionAngle={{ m.friction_angle }})),  # {{ loop.index0 }} {{ m.name }}
{%- endfor %}
]
grey = (0.6, 0.6, 0.6)  # without a colour YADE reseeds Python's random numbers
{%- if needs.planes or needs.oblique_planes or needs.meshes %}

# Walls.
{%- for w in planes %}
{{ w.variable }} = O.bodies.append(wall(({{ w.point[0] }}, {{ w.point[1] }}, {{ w.point[2] }}), axis={{ w.axis }}, sense=0, material=materials[{{ w.material }}], color=grey))  # {{ w.name }}
{%- if w.motion == "slide" %}
O.bodies[{{ w.variable }}].state.vel = Vector3({{ w.velocity[0] }}, {{ w.velocity[1] }}, {{ w.velocity[2] }})
{%- elif w.motion == "spin" %}
O.bodies[{{ w.variable }}].state.angVel = Vector3({{ w.velocity[0] }}, {{ w.velocity[1] }}, {{ w.velocity[2] }})
{%- endif %}
{%- endfor %}
{%- for w in surfaces %}
{{ w.variable }} = []  # {{ w.name }}
for line in open('{{ w.file }}'):
    if line[0] != '#':
        r = [float(word) for word in line.split()]
        {{ w.variable }}.append(facet([r[0:3], r[3:6], r[6:9]], material=materials[{{ w.material }}], color=grey))
{%- if w.motion == "turn" %}
# The facets and a point on the axis are one clump that no force moves: YADE turns it by
# its angular velocity, and every facet has the velocity of a rigid body at that time.
centre = Vector3({{ w.origin[0] }}, {{ w.origin[1] }}, {{ w.origin[2] }})
turn = Vector3({{ w.turn[0] }}, {{ w.turn[1] }}, {{ w.turn[2] }})
point = facet([(0, 0, 0), (1e-9, 0, 0), (0, 1e-9, 0)], noBound=True, material=materials[{{ w.material }}], color=grey)
point.state.pos = centre
point.state.mass = 1
point.state.inertia = Vector3(1, 2, 3)
clump, parts = O.bodies.appendClumped({{ w.variable }} + [point], discretization=0)
O.bodies[clump].state.blockedDOFs = 'xyzXYZ'
for k in [clump] + parts:
    s = O.bodies[k].state
    s.vel = turn.cross(s.pos - centre)
    s.angVel = turn
{%- if needs.springs %}
{{ w.variable }} = parts[:-1]
{%- endif %}
{%- else %}
{{ w.variable }} = O.bodies.append({{ w.variable }})
{%- endif %}
{%- if w.motion == "slide" %}
for k in {{ w.variable }}:
    O.bodies[k].state.vel = Vector3({{ w.velocity[0] }}, {{ w.velocity[1] }}, {{ w.velocity[2] }})
{%- endif %}
{%- endfor %}
{%- endif %}

# YADE's number of every sphere of the scene.
ids = [None] * {{ header.spheres }}
{%- if needs.spheres %}
for r in table('spheres.csv'):
    b = sphere(r[2:5], r[5], material=materials[int(r[1])], color=grey)
    b.state.mass = r[6]
    b.state.inertia = Vector3(r[7], r[7], r[7])
{%- if moves %}
    b.state.vel = Vector3(*r[8:11])
{%- if needs.rotation %}
    b.state.angVel = Vector3(*r[11:14])
{%- endif %}
{%- endif %}
{%- if needs.discs %}
    b.state.blockedDOFs = 'zXY'
{%- endif %}
    ids[int(r[0])] = O.bodies.append(b)
{%- endif %}
{%- if needs.arrivals %}

# Spheres that come during the run, in the order of time.
coming = table('arrivals.csv')
places = {int(r[1]): r[3:6] for r in coming}


def let_come():
    """Appends the spheres that come at the present step."""
    while coming and coming[0][0] <= O.iter:
        r = coming.pop(0)[1:]
        b = sphere(r[2:5], r[5], material=materials[int(r[1])], color=grey)
        b.state.mass = r[6]
        b.state.inertia = Vector3(r[7], r[7], r[7])
        b.state.vel = Vector3(*r[8:11])
{%- if needs.rotation %}
        b.state.angVel = Vector3(*r[11:14])
{%- endif %}
{%- if needs.discs %}
        b.state.blockedDOFs = 'zXY'
{%- endif %}
        ids[int(r[0])] = O.bodies.append(b)
{%- endif %}
{%- if needs.clumps %}

# Clumps: spheres without mass and one point (a facet that touches nothing) that
# carries the mass. They are made about the origin in their principal axes, with moments
# of which YADE takes the axes as they are, and then get their own moments and place.
clumps = []
members = table('members.csv')
for r in table('clumps.csv'):
    first, count = int(r[0]), int(r[1])
    m = materials[int(r[2])]
    x = Vector3(*r[3:6])
    q = Quaternion(*r[6:10])
    point = facet([(0, 0, 0), (1e-9, 0, 0), (0, 1e-9, 0)], noBound=True, material=m, color=grey)
    point.state.pos = Vector3(0, 0, 0)
    point.state.mass = r[10]
    point.state.inertia = Vector3(1, 2, 3)
    spheres = [sphere(s[1:4], s[4], material=m, color=grey) for s in members[first:first + count]]
    clump, parts = O.bodies.appendClumped(spheres + [point], discretization=0)
    v = Vector3(*r[14:17])
    w = Vector3(*r[17:20])
    state = O.bodies[clump].state
    state.inertia = Vector3(*r[11:14])
    state.pos = x
    state.ori = q
    state.vel = v
    state.angVel = w
{%- if needs.discs %}
    state.blockedDOFs = 'zXY'
{%- else %}
    state.angMom = Vector3(*r[20:23])  # YADE steps this and takes angVel from it
{%- endif %}
    for k in parts:
        s = O.bodies[k].state
        arm = q * s.pos
        s.pos = x + arm
        s.ori = q * s.ori
        s.vel = v + w.cross(arm)
        s.angVel = w
    for s, k in zip(members[first:first + count], parts):
        ids[int(s[0])] = k
    clumps.append(clump)
{%- endif %}
{%- if needs.periodic %}

# Space repeats itself; places are counted on and not wrapped.
O.periodic = True
O.cell.setBox({{ cell[0] }}, {{ cell[1] }}, {{ cell[2] }})
{%- endif %}

O.dt = {{ header.step }}
O.engines = [
    ForceResetter(),
{%- if oscillating %}
    PyRunner(command='walls_of_now()', iterPeriod=1, initRun=True),
{%- endif %}
    InsertionSortCollider([Bo1_Sphere_Aabb(){% if planes %}, Bo1_Wall_Aabb(){% endif %}{% if surfaces %}, Bo1_Facet_Aabb(){% endif %}], verletDist={{ verlet }}),
    InteractionLoop(
        [{% if needs.bonds %}Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=False){% else %}Ig2_Sphere_Sphere_ScGeom(){% endif %}{% if planes %}, Ig2_Wall_Sphere_ScGeom(){% endif %}{% if surfaces %}, Ig2_Facet_Sphere_ScGeom(){% endif %}],
{%- if many_frictions %}
        # One angle for every pair: (material, material, angle).
        [Ip2_ViscElMat_ViscElMat_ViscElPhys(frictAngle=MatchMaker(matches=(
{%- for p in frictions %}
            (materials[{{ p[0] }}], materials[{{ p[1] }}], math.atan({{ p[2] }})),
{%- endfor %}
        ))){% if needs.bonds %}, Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(){% endif %}],
{%- else %}
        [Ip2_ViscElMat_ViscElMat_ViscElPhys(){% if needs.bonds %}, Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(){% endif %}],
{%- endif %}
        [Law2_ScGeom_ViscElPhys_Basic(){% if needs.bonds %}, Law2_ScGeom6D_CohFrictPhys_CohesionMoment(){% endif %}],
    ),
{%- if needs.bonds %}
    PyRunner(command='note_breaks()', iterPeriod={{ bonds_every }}, initRun=True),
{%- endif %}
{%- if needs.zeroing %}
    PyRunner(command='stop_bodies()', iterPeriod={{ zero_every }}, firstIterRun={{ zero_every }}),
{%- endif %}
{%- if lost_every %}
    PyRunner(command='take_out()', iterPeriod={{ lost_every }}, firstIterRun={{ lost_every }}),
{%- endif %}
{%- if oscillating or servos %}
    PyRunner(command='move_walls()', iterPeriod=1, initRun=True),
{%- endif %}
    NewtonIntegrator(damping={{ damping }}{% if needs.gravity %}, gravity=({{ gravity[0] }}, {{ gravity[1] }}, {{ gravity[2] }}){% endif %}),
]

{%- if oscillating or servos %}


def give(wall, velocity):
    """All parts of a wall move with `velocity`."""
    for k in wall if isinstance(wall, list) else [wall]:
        O.bodies[k].state.vel = velocity


{%- endif %}
{%- if oscillating %}

# Walls that go back and forth: wall, amplitude, frequency, phase.
oscillating = [
{%- for w in oscillating %}
    ({{ w.variable }}, Vector3({{ w.amplitude[0] }}, {{ w.amplitude[1] }}, {{ w.amplitude[2] }}), {{ w.frequency }}, {{ w.phase }}),
{%- endfor %}
]


def walls_of_now():
    """Forces see the velocities that the walls have at this time."""
    for wall, amplitude, frequency, phase in oscillating:
        rate = 2 * math.pi * frequency
        give(wall, amplitude * (rate * math.cos(rate * (O.iter * O.dt) + phase)))


{%- endif %}
{%- if servos %}

# Walls that seek a force: wall, direction, force, largest speed. The velocity is such that it
# would close half of what is missing if nothing but the contacts of the wall gave way.
servos = [
{%- for w in servos %}
    ({{ w.variable }}, Vector3({{ w.direction[0] }}, {{ w.direction[1] }}, {{ w.direction[2] }}), {{ w.force }}, {{ w.speed }}),
{%- endfor %}
]


def wanted(wall, direction, asked, fastest):
    force = stiffness = 0.0
    for k in wall if isinstance(wall, list) else [wall]:
        for i in O.bodies[k].intrs():
            if not i.isReal:
                continue
            # The normal leads from the first of the two to the second, forces act on the second.
            side = 1.0 if i.id1 == k else -1.0
            along = i.geom.normal.dot(direction)
            spring = i.geom.normal * (i.phys.kn * i.geom.penetrationDepth) + i.phys.shearForce
            force += side * spring.dot(direction)
            stiffness += i.phys.kn * along**2 + i.phys.ks * (1 - along**2)
    if stiffness == 0:
        return fastest
    return max(-fastest, min(fastest, 0.5 * (asked - force) / (stiffness * O.dt)))


{%- endif %}
{%- if oscillating or servos %}


def move_walls():
    """The next step takes walls by the velocities that they have now."""
{%- if oscillating %}
    for wall, amplitude, frequency, phase in oscillating:
        rate = 2 * math.pi * frequency
        now, then = rate * (O.iter * O.dt) + phase, rate * ((O.iter + 1) * O.dt) + phase
        give(wall, amplitude * ((math.sin(then) - math.sin(now)) / O.dt))
{%- endif %}
{%- if servos %}
    for wall, direction, asked, fastest in servos:
        give(wall, direction * wanted(wall, direction, asked, fastest))
{%- endif %}
{%- endif %}
{%- if needs.springs %}

# Contacts that have a tangential spring at the start: sphere, kind of what it touches (0 sphere,
# 1 plane, 2 triangle), number of that, triangle, force of the spring on the sphere.
walls = [{% for name in walls %}{{ name }}, {% endfor %}]
for r in table('springs.csv'):
    a, kind, other, triangle = ids[int(r[0])], int(r[1]), int(r[2]), int(r[3])
    b = ids[other] if kind == 0 else walls[other] if kind == 1 else walls[other][triangle]
    i = createInteraction(a, b)
    # In the step in which an interaction became real the law empties its spring.
    i.iterMadeReal = -1
    i.phys.shearForce = Vector3(*r[4:7]) * (-1 if i.id1 == a else 1)
{%- endif %}
{%- if needs.bonds %}

# Bonds: without force where the spheres are now, friction only when they have broken.
bonds = []
glue = CohFrictMat(young=1, poisson=1, frictionAngle=0.1, isCohesive=False)
for r in table('bonds.csv'):
    a, b = int(r[0]), int(r[1])
    # The law of the pair comes from its materials, which are YADE's cohesive one meanwhile. (An
    # object made in Python would take YADE down when the bond breaks.)
    pair = [O.bodies[ids[a]], O.bodies[ids[b]]]
    own = [body.mat for body in pair]
    for body in pair:
        body.mat = glue
    i = createInteraction(ids[a], ids[b])
    for body, mat in zip(pair, own):
        body.mat = mat
    p = i.phys
    p.kn, p.ks, p.normalAdhesion, p.shearAdhesion, p.tangensOfFrictionAngle = r[2:7]
    p.unp = i.geom.penetrationDepth
    p.fragile, p.cohesionBroken, p.cohesionDisablesFriction = True, False, True
    bonds.append((len(bonds), a, b))
breaks = open('breaks.txt', 'w')
breaks.write('step,bond,first,second,mode\n')


def note_breaks():
    """Step, bond and both spheres of every bond that broke{% if bonds_every > 1 %} in the last {{ bonds_every }} steps{% endif %}."""
    for bond in list(bonds):
        k, a, b = bond
        here = O.interactions.has(ids[a], ids[b], True)
        phys = O.interactions[ids[a], ids[b]].phys if here else None
        if isinstance(phys, CohFrictPhys) and not phys.cohesionBroken:
            continue
        # Pulled apart, the interaction goes at once; sheared off, friction stays.
        mode = 'shear' if isinstance(phys, CohFrictPhys) else 'tension'
        breaks.write('%d,%d,%d,%d,%s\n' % (O.iter, k, a, b, mode))
        bonds.remove(bond)
    breaks.flush()
{%- endif %}

{%- if needs.restarts %}

# --resume: the newest restart file takes the place of the scene as it was built; numbers of
# bodies are the same.
saved = [int(name.split('.')[1]) for name in glob.glob('restart.*.xml.gz')]
resumed = '--resume' in sys.argv and len(saved) > 0
if resumed:
    O.load('restart.%d.xml.gz' % max(saved), quiet=True)
    print('riprap goes on from step', O.iter, flush=True)
frames = open('frames.txt', 'a' if resumed else 'w')
{%- else %}

frames = open('frames.txt', 'w')
{%- endif %}
{%- if lost_every %}

# Spheres that have left the domain and were taken out, and where.
gone = {}
room = [({{ room[0][0] }}, {{ room[0][1] }}), ({{ room[1][0] }}, {{ room[1][1] }}), ({{ room[2][0] }}, {{ room[2][1] }})]


def take_out():
    """Erases spheres whose centre is outside."""
    for k in ids:
        if k not in gone:
            place = Vector3(O.bodies[k].state.pos)
            if not all(low <= x <= high for x, (low, high) in zip(place, room)):
                gone[k] = place
                O.bodies.erase(k)
{%- endif %}
{%- if needs.zeroing %}


def stop_bodies():
    """Velocities and spins become zero, up to step {{ zero_until }}."""
    if O.iter > {{ zero_until }}:
        return
    for k in ids:
        O.bodies[k].state.vel = O.bodies[k].state.angVel = Vector3(0, 0, 0)
{%- endif %}


def digits(*vectors):
    return ' '.join('%.17g' % value for vector in vectors for value in vector)


def write_frame():
    """Step; x v{% if needs.rotation %} w{% endif %} f of every sphere{% if needs.clumps %}; then x q(wxyz) v w of every clump{% endif %}."""
    frames.write('frame %d\n' % O.iter)
    for {% if needs.arrivals %}index, k in enumerate(ids){% else %}k in ids{% endif %}:
{%- if needs.arrivals %}
        if k is None:
            frames.write(digits(places[index], [0.0] * {% if needs.rotation %}9{% else %}6{% endif %}) + '\n')
            continue
{%- endif %}
{%- if lost_every %}
        if k in gone:
            frames.write(digits(gone[k], [0.0] * {% if needs.rotation %}9{% else %}6{% endif %}) + '\n')
            continue
{%- endif %}
        s = O.bodies[k].state
        frames.write(digits(s.pos, s.vel, {% if needs.rotation %}s.angVel, {% endif %}O.forces.f(k)) + '\n')
{%- if needs.clumps %}
    for k in clumps:
        s = O.bodies[k].state
        q = s.ori
        frames.write(digits(s.pos, (q[3], q[0], q[1], q[2]), s.vel, s.angVel) + '\n')
{%- endif %}
    frames.flush()


steps = {{ header.steps }}
frame_every = {{ frame_every }}
report_every = {{ report_every }}
wall_seconds = cpu_seconds = 0.0
{%- if needs.restarts %}
restart_every = {{ restart_every }}
if not resumed:
    write_frame()
{%- else %}
write_frame()
{%- endif %}
while O.iter < steps:
    here = O.iter
    there = min(steps, (here // frame_every + 1) * frame_every, (here // report_every + 1) * report_every{% if needs.restarts %}, (here // restart_every + 1) * restart_every{% endif %}{% if needs.arrivals %}, int(coming[0][0]) if coming else steps{% endif %})
    wall, cpu = time.perf_counter(), time.process_time()
    O.run(there - here)
    while O.running:
        time.sleep(0.0002)  # O.run(n, True) looks only every 40 ms
    O.wait()
    wall_seconds += time.perf_counter() - wall
    cpu_seconds += time.process_time() - cpu
{%- if needs.arrivals %}
    let_come()
{%- endif %}
    if O.iter % frame_every == 0 or O.iter == steps:
        write_frame()
{%- if needs.restarts %}
    if O.iter % restart_every == 0:
        O.save('restart.%d.xml.gz' % O.iter, quiet=True)
{%- endif %}
    print('riprap step', O.iter, flush=True)
frames.close()

# Contacts between spheres: index index normal tangential (spring), N.
index = {k: i for i, k in enumerate(ids)}
with open('contacts.txt', 'w') as contacts:
    for i in O.interactions:
        if i.isReal and i.id1 in index and i.id2 in index:
            contacts.write('%d %d %.17g %.17g\n' % (
                index[i.id1], index[i.id2], i.phys.normalForce.dot(i.geom.normal), i.phys.shearForce.norm()))
print('riprap loop wall %.6f s cpu %.6f s peak %d KiB' % (
    wall_seconds, cpu_seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss), flush=True)
