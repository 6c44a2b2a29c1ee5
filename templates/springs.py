# Gives the contacts in start.restart ({{ solver }}, written by one process) the tangential
# springs of springs.csv: springs.restart. run.sh calls it between two starts.
import struct
import sys

springs = {}
with open('springs.csv') as lines:
    for line in lines:
        if line[0] == '#':
            continue
        r = line.split(',')
        a, kind, other = int(r[0]), int(r[1]), int(r[2])
        x = [float(word) for word in r[3:6]]
        springs[a, kind, other] = x
        if kind == 0:  # the other sphere has it with the other sign
            springs[other, 0, a] = [-c for c in x]

with open('start.restart', 'rb') as file:
    data = bytearray(file.read())

# The atoms stand {{ tail }} bytes before the end: how many doubles, and they. Every atom begins with its
# length: {{ own }} doubles of its own, then what each fix keeps of it, which begins with its length too.
def atoms(count, at):
    found, k = [], 0
    while k < count:
        size = struct.unpack_from('<d', data, at + 8 * k)[0]
        if not {{ own }} <= size <= count - k or size != int(size):
            return None
        found.append((at + 8 * k, int(size)))
        k += int(size)
    return found


def block():
    for count in range({{ own }}, len(data) // 8):
        at = len(data) - {{ tail }} - 8 * count
        if at < 4:
            break
        if struct.unpack_from('<i', data, at - 4)[0] == count:
            found = atoms(count, at)
            if found is not None and len(found) == {{ spheres }}:
                return found
    sys.exit('springs.py: start.restart does not end with {{ spheres }} spheres')


def whole(at):
    return struct.unpack_from('<q', data, at)[0]


def number(at):
    """Counts and numbers of partners are kept as {% if plain_numbers %}doubles{% else %}whole numbers of 64 bits{% endif %}."""
    return {% if plain_numbers %}int(struct.unpack_from('<d', data, at)[0]){% else %}whole(at){% endif %}


given = set()
for start, size in block():
    me = whole(start + 8 * 4)
    parts, k = [], {{ own }}
    while k < size:
        length = int(struct.unpack_from('<d', data, start + 8 * k)[0])
        parts.append((start + 8 * k, length))
        k += length
    # {{ planes }} plane walls, each with a spring, {% if contacts_first %}after{% else %}before{% endif %} the contacts with spheres.
    for plane in range({{ planes }}):
        x = springs.get((me, 1, plane))
        if x:
            struct.pack_into('<3d', data, parts[plane{% if contacts_first %} + 1{% endif %}][0] + 8, *x)
            given.add((me, 1, plane))
    at = parts[{% if contacts_first %}0{% else %}-1{% endif %}][0] + 8
    for k in range(number(at)):
        entry = at + 8 + 32 * k  # the partner and its spring
        other = number(entry)
        x = springs.get((me, 0, other))
        if x:
            struct.pack_into('<3d', data, entry + 8, *x)
            given.add((me, 0, other))
lacking = [key for key in springs if key not in given]
if lacking:
    sys.exit('springs.py: %d springs have no contact, the first %s' % (len(lacking), lacking[0]))
with open('springs.restart', 'wb') as file:
    file.write(data)
