#!/usr/bin/python3
"""The billet of AA6008 by GetDP, from its entry in tests/record: a second code for the heat of a casting.

    getdp_billet.py BIN [--within MM] [--keep FOLDER]     BIN: folder of dccast-billet

GetDP (Debian's `getdp`) solves the steady heat problem of the strand, melt at rest: conduction and the motion of the
metal on 1 mm cells. dccast-billet casts the same billet until its isotherms stand still. Prints both beside the
measured depths; ends with 1 where the two differ by more than MM at any of them.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/record"))
import record  # noqa: E402

ENTRY = "billet-aa6008-155"
RING = 0.1  # [m] of metal above the ring, within the 0.05 to 0.17 m of the entry, as in aa6008.toml
LENGTH = 0.45  # [m] below the level; isotherms end at half of it
ACROSS, ALONG = 24, 450  # cells
SMOOTH = 5.0  # [K] of the tangent: half of what a cell spans
KELVIN = 273.15

PROBLEM = """
Group {{ Metal = Region[1]; Side = Region[2]; Top = Region[3]; Foot = Region[4]; }}
Function {{
  h[] = InterpolationLinear[$1]{{List[{{ {enthalpy} }}]}};
  c[] = (h[$1 + {smooth:g}] - h[$1 - {smooth:g}]) / (2 * {smooth:g});
  liquid[] = InterpolationLinear[$1]{{List[{{ {fraction} }}]}};
  boiling[] = ($1 + {kelvin:g} > 373) ? 20.8 * ($1 + {kelvin:g} - 373)^3 : 0;
  film[] = (-1.67e5 + 352 * ($1 + {water:g} + 2 * {kelvin:g})) * {flow:.9g}^(1/3) * ($1 - {water:g}) + boiling[$1];
  wet[] = (film[$1] > 4e6) ? 4e6 : film[$1];
  s[] = -Y[];
  loss[] = (s[] < {ring:g}) ? 0 :
           (s[] < {ring:g} + 0.040) ? (1325 * liquid[$1] + 40 * (1 - liquid[$1])) * ($1 - {water:g}) :
           (s[] < {ring:g} + 0.057) ? (1250 * liquid[$1] + 40 * (1 - liquid[$1])) * ($1 - {water:g}) : wet[$1];
  slope[] = (loss[$1 + 1] - loss[$1 - 1]) / 2;
}}
Constraint {{
  {{ Name Poured; Case {{ {{ Region Top; Value {poured:g}; }} }} }}
  {{ Name Guess; Case {{ {{ Region Metal; Type Init; Value (s[] < {ring:g}) ? {poured:g} : 150; }} }} }}
}}
Jacobian {{
  {{ Name Volume; Case {{ {{ Region All; Jacobian VolAxi; }} }} }}
  {{ Name Surface; Case {{ {{ Region All; Jacobian SurAxi; }} }} }}
}}
Integration {{ {{ Name Points; Case {{ {{ Type Gauss; Case {{
  {{ GeoElement Line; NumberOfPoints 2; }} {{ GeoElement Quadrangle; NumberOfPoints 4; }} }} }} }} }} }}
FunctionSpace {{ {{ Name Temperatures; Type Form0;
  BasisFunction {{ {{ Name n; NameOfCoef t; Function BF_Node; Support Region[{{Metal, Side, Foot}}]; Entity NodesOf[All]; }} }}
  Constraint {{ {{ NameOfCoef t; EntityType NodesOf; NameOfConstraint Poured; }}
               {{ NameOfCoef t; EntityType NodesOf; NameOfConstraint Guess; }} }} }} }}
Formulation {{ {{ Name Strand; Type FemEquation;
  Quantity {{ {{ Name t; Type Local; NameOfSpace Temperatures; }} }}
  Equation {{
    Galerkin {{ [ {conductivity:g} * Dof{{d t}}, {{d t}} ]; In Metal; Integration Points; Jacobian Volume; }}
    Galerkin {{ [ Vector[0, {speed:g} * h[{{t}}], 0], {{d t}} ]; In Metal; Integration Points; Jacobian Volume; }}
    Galerkin {{ JacNL [ Vector[0, {speed:g} * c[{{t}}], 0] * Dof{{t}}, {{d t}} ]; In Metal; Integration Points; Jacobian Volume; }}
    Galerkin {{ [ {speed:g} * h[{{t}}], {{t}} ]; In Foot; Integration Points; Jacobian Surface; }}
    Galerkin {{ JacNL [ {speed:g} * c[{{t}}] * Dof{{t}}, {{t}} ]; In Foot; Integration Points; Jacobian Surface; }}
    Galerkin {{ [ loss[{{t}}], {{t}} ]; In Side; Integration Points; Jacobian Surface; }}
    Galerkin {{ JacNL [ slope[{{t}}] * Dof{{t}}, {{t}} ]; In Side; Integration Points; Jacobian Surface; }}
  }} }} }}
Resolution {{ {{ Name Steady; System {{ {{ Name A; NameOfFormulation Strand; }} }}
  Operation {{ InitSolution[A]; IterativeLoop[60, 1e-6, 0.3] {{ GenerateJac[A]; SolveJac[A]; }} SaveSolution[A]; }} }} }}
PostProcessing {{ {{ Name Depths; NameOfFormulation Strand;
  Quantity {{ {{ Name t; Value {{ Term {{ [ {{t}} ]; In Metal; Jacobian Volume; }} }} }} }} }} }}
PostOperation {{ {{ Name Lines; NameOfPostProcessing Depths; Operation {{ {lines} }} }} }}
"""


def data_of(entry):
    """{what: datum} of an entry."""
    return {datum["what"]: datum for datum in entry["cast"]}


def problem(entry):
    """Text of the problem in GetDP's language, temperatures in degC."""
    of = data_of(entry)
    value = {what: datum["value"] for what, datum in of.items() if isinstance(datum.get("value"), (int, float))}
    fraction = [(t - KELVIN, share) for t, share in of["liquid fraction"]["table"]]
    # Of a fixed volume, whose metal is the lighter the hotter it is: what dccast stores by default.
    enthalpy, last = [(-100.0, 0.0)], (-100.0, 0.0)
    for t, share in fraction + [(1000.0, 1.0)]:
        melted = share - last[1]
        mean = 0.5 * (share + last[1])
        density = (1 - mean) * value["density, solid"] + mean * value["density, liquid"]
        heat = density * (value["specific heat"] * (t - last[0]) + value["latent heat"] * melted)
        enthalpy.append((t, enthalpy[-1][1] + heat))
        last = (t, share)
    radius = 0.5 * value["diameter"]
    radii = sorted({figure["at"]["radius_m"] for figure in entry["measured"]})
    lines = " ".join("Print[ t, OnLine{{%g, 0, 0}{%g, %g, 0}} {%d}, Format SimpleTable, File \"line%d.txt\" ];" % (
        r, r, -LENGTH, 2 * ALONG, i) for i, r in enumerate(radii))
    numbers = {"enthalpy": enthalpy, "fraction": [(-100.0, 0.0), *fraction, (1000.0, 1.0)]}
    return PROBLEM.format(
        lines=lines, ring=RING, smooth=SMOOTH, kelvin=KELVIN, water=328.5 - KELVIN, poured=value["temperature of the metal"] - KELVIN,
        flow=1e-3 * value["water"] / 60 / (2 * 3.141592653589793 * radius), conductivity=value["conductivity"],
        speed=1e-3 * value["casting speed"],
        **{name: ", ".join("%.9g, %.9g" % pair for pair in pairs) for name, pairs in numbers.items()}), radii


def mesh(radius):
    """Equal cells, as Gmsh writes them: 1 metal, 2 side, 3 top, 4 foot."""
    def node(i, j):
        return 1 + i + j * (ACROSS + 1)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str((ACROSS + 1) * (ALONG + 1))]
    lines += ["%d %.12g %.12g 0" % (node(i, j), radius * i / ACROSS, -LENGTH * j / ALONG)
              for j in range(ALONG + 1) for i in range(ACROSS + 1)]
    cells = [(3, 1, node(i, j), node(i, j + 1), node(i + 1, j + 1), node(i + 1, j))
             for j in range(ALONG) for i in range(ACROSS)]
    cells += [(1, 2, node(ACROSS, j), node(ACROSS, j + 1)) for j in range(ALONG)]
    cells += [(1, group, node(i, j), node(i + 1, j)) for group, j in ((3, 0), (4, ALONG)) for i in range(ACROSS)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += ["%d %d 2 %d %d %s" % (number, kind, group, group, " ".join(map(str, nodes)))
              for number, (kind, group, *nodes) in enumerate(cells, start=1)]
    return "\n".join([*lines, "$EndElements", ""])


def depth(line, wanted):
    """[m] below the level where the temperature last falls through `wanted`. @param line  (depth, temperature)"""
    found = None
    for (d0, t0), (d1, t1) in zip(line, line[1:]):
        if t0 >= wanted > t1:
            found = d0 + (d1 - d0) * (t0 - wanted) / (t0 - t1)
    return found


def getdp(folder, entry):
    """Depths of the entry's figures by GetDP [m below the ring]."""
    text, radii = problem(entry)
    (folder / "billet.pro").write_text(text)
    (folder / "billet.msh").write_text(mesh(0.5 * data_of(entry)["diameter"]["value"]))
    ended = subprocess.run(["getdp", "billet.pro", "-msh", "billet.msh", "-solve", "Steady", "-pos", "Lines", "-v", "3"],
                           cwd=folder, capture_output=True, text=True, check=False)
    if ended.returncode:
        sys.exit("GetDP did not come to the end:\n" + ended.stdout[-2000:] + ended.stderr[-2000:])
    lines = {}
    for i, radius in enumerate(radii):
        rows = [line.split() for line in (folder / f"line{i}.txt").read_text().splitlines()]
        lines[radius] = [(-float(row[1]), float(row[3])) for row in rows]
    return [depth(lines[figure["at"]["radius_m"]], figure["at"]["temperature_c"]) - RING
            for figure in entry["measured"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--within", type=float, default=1.0, help="mm")
    parser.add_argument("--keep", help="folder for the files; absent: a scratch folder")
    options = parser.parse_args()
    entry = record.entries()[ENTRY]
    with tempfile.TemporaryDirectory(prefix="getdp-billet-") as scratch:
        theirs = getdp(pathlib.Path(options.keep or scratch), entry)
    ours = [value - RING for value in json.loads(subprocess.run(
        [options.bin / "dccast-billet", "rest"], check=True, capture_output=True, text=True).stdout)[ENTRY]]

    print("| radius [mm] | isotherm [degC] | measured [mm] | GetDP [mm] | dccast [mm] | dccast less GetDP [mm] |")
    print("|---|---|---|---|---|---|")
    for figure, a, b in zip(entry["measured"], theirs, ours, strict=True):
        print("| %g | %g | %.1f | %.1f | %.1f | %+.1f |" % (
            1e3 * figure["at"]["radius_m"], figure["at"]["temperature_c"], 1e3 * figure["value"], 1e3 * a, 1e3 * b,
            1e3 * (b - a)))
    largest = 1e3 * max(abs(a - b) for a, b in zip(theirs, ours))
    print(f"largest difference {largest:.2f} mm, {options.within:g} permitted")
    return largest > options.within


if __name__ == "__main__":
    sys.exit(main())
