"""FMUs as an importer calls them, function by function, through FMPy."""

import ctypes
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

OK, ERROR = 0, 3


class Imported:
    """An FMU of either standard; what it says of errors is kept."""

    def __init__(self, path: Path, exchange: bool = False, folder: str = "", **more: Any) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.fmi = int(self.description.fmiVersion[0])
        self.variables = {one.name: one for one in self.description.modelVariables}
        self.folder, self.exchange = folder or fmpy.extract(str(path)), exchange
        kind = {(2, True): "FMU2Model", (2, False): "FMU2Slave", (3, True): "FMU3Model", (3, False): "FMU3Slave"}
        module = fmpy.fmi2 if self.fmi == 2 else fmpy.fmi3
        part = self.description.modelExchange if exchange else self.description.coSimulation
        self.fmu = getattr(module, kind[self.fmi, exchange])(
            guid=self.description.guid, unzipDirectory=self.folder, modelIdentifier=part.modelIdentifier,
            instanceName="one",
        )  # fmt: skip
        self.fmu.instantiate(**more)

    def start(self, values: Mapping[str, float] = {}, begin: float = 0.0, stop: float | None = None) -> "Imported":
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=begin, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=begin, stopTime=stop)
        self.set(**values)
        self.fmu.exitInitializationMode()
        return self

    def place(self, name: str) -> int:
        return int(self.variables[name].valueReference) if name in self.variables else {"time": 0}[name]

    def set(self, **values: float) -> None:
        setter = self.fmu.setReal if self.fmi == 2 else self.fmu.setFloat64
        setter([self.place(name) for name in values], list(values.values()))

    def get(self, *names: str) -> np.ndarray:
        getter = self.fmu.getReal if self.fmi == 2 else self.fmu.getFloat64
        return np.array(getter([self.place(name) for name in names]))

    def whole(self, name: str) -> int:
        return int(getattr(self.fmu, f"get{self.variables[name].type}")([self.place(name)])[0])

    def put_states(self, values: Sequence[float]) -> None:
        array = (ctypes.c_double * len(values))(*values)
        self.fmu.setContinuousStates(array, len(values))

    def step(self, time: float, length: float) -> Any:
        return self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=length)

    def slope(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        places = [self.place(name) for name in unknown], [self.place(name) for name in known]
        return np.array(self.fmu.getDirectionalDerivative(*places, list(seed)))

    def refuses(self, what: Any, *arguments: Any, **more: Any) -> bool:
        """Whether a call is answered by an error, not by another state."""
        try:
            what(*arguments, **more)
        except Exception as error:
            return "failed with status" in str(error) and "rror" in str(error)
        return False


@contextmanager
def imported(path: Path, exchange: bool = False, **more: Any) -> Iterator[Imported]:
    fmu = Imported(path, exchange, **more)
    try:
        yield fmu
    finally:
        fmu.fmu.freeInstance()
        shutil.rmtree(fmu.folder, ignore_errors=True)
