#!/usr/bin/python3
"""The corner of a plate that is warm below and cold above, by CalculiX: finite strains over small strains.

    calculix_plate.py [DEGREES...]

CalculiX is Debian's `calculix-ccx`, which nothing else needs. A quarter of the plate, 0.66 x 0.285 x 0.1 m, in
bricks of 20 nodes, held on its planes of symmetry and at its centre. The temperature is linear over its height; its
slope would bend the long side by so many degrees. tests/unit/mechanics/kinematics_test.cpp holds dccast against it.
"""
import argparse
import math
import os
import subprocess
import tempfile

SIZE = (0.66, 0.285, 0.1)  # [m]
CELLS = (10, 5, 2)
# Corners, then middles of edges, in half cells.
BRICK = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
         (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
         (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1))


def bricks():
    """Numbers of the nodes by place, in half cells, and the nodes of each brick."""
    number, elements = {}, []
    for column in range(CELLS[0]):
        for row in range(CELLS[1]):
            for layer in range(CELLS[2]):
                begin = (2 * column, 2 * row, 2 * layer)
                places = [tuple(b + offset for b, offset in zip(begin, corner)) for corner in BRICK]
                elements.append([number.setdefault(place, len(number) + 1) for place in places])
    return number, elements


def deck(angle, finite):
    """The input of CalculiX and the number of the corner's node."""
    number, elements = bricks()
    place = {n: [size * at / (2 * cells) for size, at, cells in zip(SIZE, where, CELLS)]
             for where, n in number.items()}
    corner = number[(2 * CELLS[0], 2 * CELLS[1], 0)]
    slope = angle / SIZE[0]

    lines = ["*NODE,NSET=ALL", *(f"{n},{x:.9g},{y:.9g},{z:.9g}" for n, (x, y, z) in place.items()),
             "*ELEMENT,TYPE=C3D20R,ELSET=PLATE"]
    for e, nodes in enumerate(elements, 1):
        lines += [f"{e}," + ",".join(map(str, nodes[:10])) + ",", ",".join(map(str, nodes[10:]))]
    lines += ["*MATERIAL,NAME=METAL", "*ELASTIC", "7e10,0.3", "*EXPANSION,ZERO=0", "1.",
              "*SOLID SECTION,ELSET=PLATE,MATERIAL=METAL",
              "*INITIAL CONDITIONS,TYPE=TEMPERATURE", "ALL,0", "*NSET,NSET=CORNER", f"{corner}",
              "*BOUNDARY", *(f"{n},1" for where, n in number.items() if where[0] == 0),
              *(f"{n},2" for where, n in number.items() if where[1] == 0), f"{number[0, 0, 0]},3",
              "*STEP,NLGEOM,INC=500" if finite else "*STEP", "*STATIC"]
    if finite:
        lines.append("0.05,1.,1e-5,0.05")
    lines += ["*TEMPERATURE", *(f"{n},{slope * (SIZE[2] / 2 - z):.12g}" for n, (_, _, z) in place.items()),
              "*NODE PRINT,NSET=CORNER", "U", "*END STEP"]
    return "\n".join(lines) + "\n", corner


def lift(folder, angle, finite):
    """Of the corner [m]."""
    text, corner = deck(angle, finite)
    with open(os.path.join(folder, "plate.inp"), "w", encoding="ascii") as file:
        file.write(text)
    subprocess.run(["ccx", "-i", "plate"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(folder, "plate.dat"), encoding="ascii") as file:
        rows = [line.split() for line in file.read().rsplit("displacements", 1)[1].splitlines()]
    return next(float(row[3]) for row in rows if row and row[0] == str(corner))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("degrees", nargs="*", type=float, default=[5.0, 10.0, 15.0, 20.0, 25.0])
    with tempfile.TemporaryDirectory() as folder:
        for degrees in parser.parse_args().degrees:
            angle = math.radians(degrees)
            ratio = lift(folder, angle, True) / lift(folder, angle, False)
            print(f"{degrees:g} degrees: {ratio:.4f}", flush=True)


if __name__ == "__main__":
    main()
