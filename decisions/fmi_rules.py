"""Rules of the FMI standard that exported FMUs are held to, by whose checker: table of docs/export.md.

python decisions/fmi_rules.py          # prints it
python decisions/fmi_rules.py --write  # and puts it into docs/

VDMCheck2.sh and VDMCheck3.sh of the INTO-CPS Association's FMI-VDM-Model, and libcosimpy, are asked where they are.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import fmpy
import numpy as np
from fmpy.validation import validate_fmu
from lxml import etree
from pages import markdown, publish

import narrows as nw
from narrows.model.tables import table_named
from narrows.waterway import Bank, Centreline, Waterway

SCHEMAS = Path(fmpy.__file__).parent / "schema"
ABSENT = "not here"


def ships() -> dict[str, tuple[nw.Model, Waterway | None]]:
    """The DTC, the same in a waterway, and the KVLCC2 with rudder and propeller, its bank borrowed."""
    dtc, tanker = nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2")
    known = {**tanker.coefficients, "Y_bank": dtc["b_bank"], "N_bank": dtc["c_bank"]}
    steered = nw.Model(replace(tanker.configuration, canal=nw.Canal(14.0)), table_named("mmg+delta"), known)
    line = Centreline(np.array([[0.0, 0.0], [0.0, 30.0], [5.0, 60.0]]))
    ends = np.array([0.0, line.length])
    banks = [Bank(side, ends, np.array([3.5, 3.0])) for side in ("starboard", "port")]
    return {"DTC": (dtc, None), "DTC in a waterway": (dtc, Waterway(line, *banks)), "KVLCC2": (steered, None)}


def by_schema(path: Path, fmi: int) -> str:
    """What the standard's own schema says of a description."""
    schema = etree.XMLSchema(etree.parse(SCHEMAS / f"fmi{fmi}" / f"fmi{fmi}ModelDescription.xsd"))
    with tempfile.TemporaryDirectory() as folder:
        text = Path(fmpy.extract(str(path), folder), "modelDescription.xml").read_bytes()
    schema.validate(etree.fromstring(text))
    return counted(len(schema.error_log))


def by_fmpy(path: Path, fmi: int) -> str:
    """What FMPy finds."""
    return counted(len(validate_fmu(str(path))))


def by_rules(path: Path, fmi: int) -> str:
    """What the formal rules find."""
    program = shutil.which(f"VDMCheck{fmi}.sh")
    if program is None:
        return ABSENT
    said = subprocess.run([program, path], capture_output=True, text=True).stdout.strip().splitlines()
    return counted(0 if said[-1] == "No errors found." else sum("https://fmi-standard.org" in line for line in said))


def by_libcosim(path: Path, fmi: int) -> str:
    """What libcosim says where it loads and steps it; it supports FMI 2.0 only."""
    if fmi != 2:
        return "FMI 2.0 only"
    steps = (
        "import sys; from libcosimpy.CosimExecution import CosimExecution as E; from libcosimpy.CosimSlave import "
        "CosimLocalSlave as S; e = E.from_step_size(step_size=100_000_000); "
        "e.add_local_slave(S(fmu_path=sys.argv[1], instance_name='ship')); assert e.simulate_until(1_000_000_000)"
    )
    done = subprocess.run([sys.executable, "-c", steps, path], capture_output=True, text=True)
    words = re.findall(r"\[(?:warning|error|fatal)\]", done.stdout)
    return ABSENT if "ModuleNotFoundError" in done.stderr else counted(len(words) + (done.returncode != 0))


def counted(problems: int) -> str:
    """Write how many problems there are."""
    return "no findings" if problems == 0 else f"**{problems}**"


CHECKERS = {"schema": by_schema, "FMPy": by_fmpy, "VDMCheck": by_rules, "libcosim": by_libcosim}


def rules_of(fmi: int) -> str:
    """How many rules the formal model names, where it is here."""
    program = shutil.which(f"VDMCheck{fmi}.sh")
    if program is None:
        return ABSENT
    rules = Path(program).resolve().parent.glob(f"fmi{fmi}-rule-model/Rules/*.adoc")
    texts = [path.read_text("utf-8") for path in rules]
    return str(len({rule for text in texts for rule in re.findall(r" Rule: (\w+)", text)}))


def rows() -> Iterator[tuple[str, ...]]:
    """Yield a row for each FMU."""
    with tempfile.TemporaryDirectory() as folder:
        for name, (model, waterway) in ships().items():
            for fmi in (2, 3):
                path = Path(folder, f"{fmi}.fmu")
                surge = "free" if name == "KVLCC2" else "held"
                nw.export.write(model, path, fmi=fmi, waterway=waterway, surge=surge)
                yield name, f"{fmi}.0", *(check(path, fmi) for check in CHECKERS.values())


if __name__ == "__main__":
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, *checked in rows():
        alike.setdefault(tuple(checked), []).append(name)
    table = markdown(("FMUs", "FMI", *CHECKERS), [(", ".join(names), *checked) for checked, names in alike.items()])
    rules = f"The formal model names {rules_of(2)} rules of FMI 2.0 and {rules_of(3)} of 3.0; FMPy {version('fmpy')}."
    publish(__file__, "export.md", f"{table}\n\n{rules}")
