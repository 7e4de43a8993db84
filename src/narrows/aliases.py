"""Names of pandas, SciPy, statsmodels, python-control and other simulators, and the names here: one row each."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from narrows.errors import InputError, near_miss

Rows = Mapping[str, tuple[str, ...]]
Function = TypeVar("Function", bound=Callable[..., Any])

# Least similarity of two public names for a suggestion [1].
NAMES_ALIKE = 0.75

# Attributes of results that are accepted under another name; brackets mark methods.
ATTRIBUTES: Rows = {
    "coefficients": ("params", "parameters", "coef_", "coef", "coeffs", "coefs", "get_params()", "values"),
    "std": ("bse", "stderr", "standard_errors", "std_errors"),
    "covariance": ("pcov", "cov()", "cov_params()", "covariance_matrix", "cov_matrix", "vcov"),
    "residuals": ("resid",), "notes": ("warnings", "caveats", "messages"), "rsquared": ("r2", "r_squared"),
    "predict()": ("fittedvalues", "fitted"),
    "forces()": ("predict()", "force()", "evaluate()"),
    "corr()": ("correlation", "correlation_matrix", "correlation()"),
    "latex()": ("to_latex()", "equations()", "equation()"),
    "poles()": ("eigenvalues()", "eigvals()", "eig()"), "eigenvalues()": ("poles()", "eigvals()", "eig()"),
    "modes()": ("damp()",), "states": ("state_labels", "state_names"),
    "controls": ("input_labels", "input_names", "inputs"),
    "state_space()": ("to_ss()", "ss()", "to_control()"),
    "with_coefficients()": ("replace()", "set_params()", "assign()", "set_coefficients()", "with_values()", "copy()",
                            "update()"),
    "with_parts()": ("replace()",),
    "to_dataframe()": ("df", "to_frame()", "to_pandas()", "summary_frame()", "trajectory", "dataframe()"),
    "dataset()": ("ds", "to_dataset()"),
    "save()": ("write()", "dump()", "to_toml()", "to_file()"),
    "plot()": ("show()", "draw()", "plot_trajectory()", "plot_track()", "plot_coefficients()", "plot_forces()",
               "heatmap()", "contour()"),
    "t": ("time", "times"), "y": ("offset", "lateral_position", "lateral_offset"), "x": ("along", "distance_along"),
    "u": ("speed", "surge", "surge_velocity"), "v": ("sway", "sway_velocity"), "r": ("yaw_rate",),
    "psi": ("heading", "yaw"), "rudder": ("rudder_angle", "delta"),
    "outcome.time": ("time_to_grounding", "grounding_time", "end_time", "t_end"),
    "outcome.distance": ("distance", "distance_travelled"),
    "outcome.sentence": ("message",), "outcome.kind": ("status", "reason"), "outcome.side": ("side",),
    "length": ("L", "Lpp", "LPP", "LBP"), "beam": ("B",), "draft": ("T",), "block_coefficient": ("Cb",),
    "ship.length": ("length", "L", "Lpp", "LPP", "LBP"), "configuration.gear": ("steering", "gear"),
    "configuration.rudder": ("rudder",), "configuration.propeller": ("propeller",),
    "ship.beam": ("beam", "B"), "ship.draft": ("draft", "T"),
    "configuration.ship": ("ship", "particulars", "hull"), "ship": ("particulars", "hull", "vessel"),
    "model.linearize()": ("linearize()",), "model.export()": ("export()",),
    "model.configuration.ship": ("ship", "particulars", "hull"), "final": ("final_state", "last", "end_state"),
    "configuration.canal": ("canal",), "canal.depth": ("depth",),
    "canal.width": ("width",), "line.length": ("length",), "line": ("centerline", "centreline", "axis"),
    "data": ("grid",),
    "highest_speed()": ("max_speed()", "safe_speed()", "maximum_speed()", "max_safe_speed()"), "safe()": ("is_safe()",),
    "summary()": ("summary2()", "report()"),
    "conf_int()": ("confint()", "ci()", "confidence_intervals()", "confidence_interval()", "confidence()"),
    "query()": ("filter()",), "nobs": ("n_observations", "n_obs", "n"),
    "terms.names": ("names", "param_names", "feature_names_in_", "model_names"), "names": ("test_names",),
    "ship.name": ("name",), "derivative()": ("rhs()", "dynamics()", "ode()"),
    "controllability()": ("is_controllable()", "ctrb()"), "simulate()": ("run()",),
    "verdicts": ("identifiability",), "influence": ("get_influence()",),
}  # fmt: skip

# Arguments at the head of public functions, by the class that has these functions as methods.
FIRST: Rows = {
    "Model": ("model", "ship"), "Fleet": ("voyages",), "Waterway": ("waterway",), "CaptiveTests": ("tests",),
    "Voyage": ("voyage",), "Configuration": ("configuration", "ship"), "Fit": ("model",), "Scaled": ("model",),
}  # fmt: skip

# Attributes with another meaning here, and what to use instead; the first that the object has is named.
INSTEAD: Rows = {
    **dict.fromkeys(("success", "converged"), ("outcome", "notes")), "figure": ("plot()",),
    **dict.fromkeys(("pvalues", "tvalues", "zvalues", "wald_test", "f_test", "t_test"), ("verdicts",)),
    **dict.fromkeys(("aic", "bic", "llf", "loglike", "rsquared_adj", "fvalue", "f_pvalue"), ("left_out",)),
    **dict.fromkeys(("jackknife", "cross_validate", "cross_val_score", "cv"),
                    ("left_out",)),
    **dict.fromkeys(("df_resid", "df_model", "dof"), ("nobs and coefficients",)),
    **dict.fromkeys(("psi_deg", "heading_deg"), ("psi, in radians",)),
    **dict.fromkeys(("data", "values_", "values"), ("to_dataframe()",)),
    **dict.fromkeys(("states", "positions", "path", "forces", "state"), ("to_dataframe()",)),
    **dict.fromkeys(("bode", "nyquist", "step_response", "root_locus", "impulse_response", "lsim"),
                    ("state_space() for python-control",)),
    **dict.fromkeys(("is_stable", "stable", "stability", "damping", "damping_ratio", "frequencies"),
                    ("modes()", "eigenvalues()", "poles()")),
    **dict.fromkeys(("info", "describe"), ("summary()",)),
    **dict.fromkeys(("write", "save"), ("nw.write_waterway(waterway, path)",)),
    **dict.fromkeys(("get_prediction", "forecast", "fitted_values"), ("predict()",)),
    **dict.fromkeys(("cook_distance", "cooks_distance", "hat", "leverage", "outliers"), ("influence",)),
    **dict.fromkeys(("mass_matrix", "M", "added_mass"), ("coefficients, in which b_vdot and c_rdot have the masses",)),
    **dict.fromkeys(("mass", "inertia"), ("ship.mass and ship.inertia, given or None",)),
    **dict.fromkeys(("limits",), ("highest_speed()",)), "max_heading": ("psi, as abs(psi).max()",),
    **dict.fromkeys(("grounded_fraction", "probability", "probability_of_grounding"),
                    ("nw.grounding_probability(fleet, distance)",)),
    **dict.fromkeys(("std", "bse", "stderr"), ("to_dataframe(), column std",)),
    **dict.fromkeys(("min_distance", "distance_to_bank", "clearance", "minimum_clearance", "min_clearance"),
                    ("outcome.clearance, at a waterway's end",)),
    **dict.fromkeys(("mse", "sse", "ssr"), ("rmse",)), "interval": ("intervals",),
    **dict.fromkeys(("t_values", "p_values", "HC0_se", "significance", "significant", "identified", "verdict"),
                    ("verdicts",)),
    **dict.fromkeys(("sel", "isel", "where"), ("dataset()",)), "velocity_range": ("data_range.speed",),
    **dict.fromkeys(("speed_range", "range", "valid_range", "limits_of_validity"), ("data_range",)),
    **dict.fromkeys(("bend_radius", "radius", "curvature"), ("section(s).curvature",)),
    **dict.fromkeys(("get_width", "get_depth"), ("section(s)",)),
    "poles": ("linearize(u=...).poles()",),
    **dict.fromkeys(("drift_angle", "drift", "beta"), ("v and u, as -arctan2(v, u)",)),
    **dict.fromkeys(("sample", "samples"), ("nw.ensemble(model, samples=...)",)),
    "chi2": ("scores",), **dict.fromkeys(("nparams", "n_params", "k_params"), ("coefficients",)),
    "runs": ("test(name)",), "equations": ("latex()", "model.latex()"), "n_tests": ("tests",),
    **dict.fromkeys(("X", "Y", "N"), ("forces(u=..., ...)",)), "end": ("outcome",),
    **dict.fromkeys(("velocity", "position", "velocities"), ("to_dataframe()",)),
    "plot_bank_force": ("plot()",),
    "condition_number": ("diagnostics.overall['Y'].condition",),
    "is_identified": ("verdicts",), "compare": ("nw.compare(tests)",),
    "simulate": ("model.simulate()",), "scale_to": ("scale(length)",),
    "derivatives": ("nw.nondimensional(model)",), "width": ("section(s).width",), "tests": ("test(name)",),
    **dict.fromkeys(("ss", "to_ss"), ("linearize().state_space()",)), "steady_state": ("nw.steady_course(model)",),
    **dict.fromkeys(("C", "D"), ("state_space() for python-control: the outputs are the states",)),
    **dict.fromkeys(("points", "coordinates", "xy"), ("line",)),
    **dict.fromkeys(("left_bank", "right_bank", "banks", "bank"), ("port and starboard",)),
    "displacement": ("length * beam * draft * block_coefficient [m3]",), "uncertainty": ("covariance",),
    **dict.fromkeys(("sensitivity", "sensitivities"), ("nw.sensitivities(model, ...)",)),
    **dict.fromkeys(("with_water", "with_density"), ("scale(length, density=...)",)),
    **dict.fromkeys(("bow", "stern"), ("nw.squat(model, u, 'bow')",)), "to_csv": ("to_dataframe().to_csv(file)",),
    **dict.fromkeys(("ax", "axes"), ("plot(), a Matplotlib figure",)),
    "bounds": ("line.points",), "set": ("with_coefficients(...), a copy",),
    "to_simulink": ("export(path), with .c for an S-function",),
    "popt": ("coefficients",),  # SciPy's is an array; these go by name
}  # fmt: skip

# Reasons why an object lacks such a number.
WHY = {
    **dict.fromkeys(("pvalues", "tvalues", "zvalues"), "rows of one run share its errors, and such tests assume none"),
    **dict.fromkeys(("aic", "bic", "llf", "df_resid"), "rows of one run are not independent"),
}

# Classes, and the functions that make their objects.
MADE_BY = {
    "Waterway": "nw.read_waterway(path) or nw.straight_waterway(canal, length)", "Fit": "nw.identify(tests)",
    "Model": "nw.load_model(path), nw.published(name) or nw.estimate_model(ship, canal)",
    "CaptiveTests": "nw.read_captive(path, ship)", "Voyage": "nw.simulate(model)", "ShipLog": "nw.read_log(path)",
    "SafeEnvelope": "nw.safe_envelope(model)", "LinearSystem": "nw.control.linearize(model)",
    "Ship": "nw.read_ship(path).ship", "Configuration": "nw.read_ship(path)", "Plan": "nw.plan_tests(configuration)",
}  # fmt: skip

# Constructors by the names of other libraries.
CONSTRUCTORS: Rows = {
    "load_model": ("Model.load", "Model.from_toml", "Model.from_file", "Model.read"),
    "published": ("Model.published", "Model.from_name"), "estimate_model": ("Model.estimate", "Model.from_dimensions"),
    "identify": ("Fit.fit", "Model.fit", "Model.identify"),
    "read_captive": ("CaptiveTests.read", "CaptiveTests.from_csv", "CaptiveTests.read_csv", "CaptiveTests.load"),
    "concat": ("CaptiveTests.concat",), "read_log": ("ShipLog.read", "ShipLog.from_csv", "ShipLog.load"),
    "read_waterway": ("Waterway.read", "Waterway.from_file", "Waterway.load", "Waterway.from_kml"),
    "straight_waterway": ("Waterway.straight",),
    "read_ship": ("Configuration.read", "Configuration.from_toml", "Configuration.load"),
}  # fmt: skip

# Arguments that are accepted under another name.
ARGUMENTS: Rows = {
    "duration": ("t_end", "tmax", "t_max", "tend", "t_final", "tfinal", "tf"),
    "dt": ("h", "delta_t", "time_step", "timestep"),
    "y": ("y0", "offset", "offsets", "lateral_offset", "initial_offset"),
    "u": ("u0", "speed", "speeds", "U", "U0", "velocity", "initial_speed"), "x": ("x0",), "v": ("v0", "sway_velocity"),
    "psi": ("psi0",), "r": ("r0", "yaw_rate"), "controller": ("pilot", "autopilot", "control", "helm"),
    "configuration": ("ship", "config"), "rudder": ("delta",),
    "samples": ("n_samples", "nsamples", "draws"), "seed": ("random_state", "rng"),
    "workers": ("n_jobs", "n_workers", "num_workers"),
    "length": ("L", "Lpp", "lpp"), "beam": ("B", "breadth"), "draft": ("T", "draught"),
    "block_coefficient": ("Cb", "cb", "CB", "block"), "width": ("W", "breadth"), "depth": ("h", "water_depth"),
}  # fmt: skip

# Arguments with another meaning here, and what to write instead.
OTHER_ARGUMENTS: Rows = {
    "terms=..., such as 'speed' or nw.MMG": ("model", "structure", "regressors", "formula"),
    "weights=... and errors=...: the method is constrained least squares": ("method", "robust", "estimator", "loss"),
    "ship=nw.Ship(...) and canal=nw.Canal(...)": ("length", "L", "Lpp", "beam", "B", "draft", "Cb"),
    "gains=..., four, for offset, heading, sway velocity and yaw rate": ("kp", "Kp", "kd", "Kd", "ki", "Ki"),
    "duration=..., and at=... for the times of the output": ("t_span", "tspan", "t_eval", "time", "t", "T"),
    "y=..., u=..., psi=...": ("initial", "state", "start", "initial_state", "initial_conditions", "ic"),
    "psi=..., in radians": ("heading", "heading0", "yaw"),
    "rudder=..., in radians, and in degrees for turning_circle and zigzag": ("rudder_angle", "angle"),
    "Y=... and N=... of nw.wind_force": ("wind", "wind_speed"), "waterway=... with a current": ("current",),
    "controller=nw.track_pilot(model, y, u)": ("hold", "setpoint"),
    "dt=...": ("step",), "samples=..., or revolutions=... of a propeller": ("n",),
    "dt=...: the method is Runge-Kutta of order 4": ("method", "solver", "rtol", "atol"),
}  # fmt: skip

# Functions that are accepted under another name.
FUNCTIONS: Rows = {
    "identify": ("fit", "regress", "ols", "fit_model", "sysid"), "learn": ("learn_log", "calibrate"),
    "load_model": ("load", "read_model", "get_model"), "read_ship": ("load_ship",),
    "read_captive": ("read_csv", "read_table", "read_excel", "read_tests", "load_tests"),
    "read_log": ("load_log", "read_ais", "read_nmea", "import_log"),
    "simulate": ("sail", "run", "integrate", "run_simulation"), "scale_model": ("scale",),
    "plan_tests": ("plan", "design", "test_plan"),
    "safe_envelope": ("envelope",), "sail_trials": ("trials",), "published": ("list_published", "published_models"),
    "read_waterway": ("read_geojson", "read_canal", "load_waterway"), "ready_ships": ("ships", "list_ships"),
    "steady_course": ("steady_state", "trim", "equilibrium"), "straight_waterway": ("straight_canal",),
    "write_waterway": ("to_geojson", "write_geojson"),
    "control.linearize": ("linearize", "linearise"), "control.lqr": ("lqr", "LQR"),
    "control.PredictiveHelm": ("mpc", "MPC"), "estimation.Estimator": ("kalman_filter", "ukf", "UKF"),
    "estimation.consistency": ("nees", "NEES", "nis"),
    "ensemble": ("monte_carlo", "sweep", "fleet", "simulate_many", "simulate_fleet", "grounding_map"),
    "bank_force": ("bank_effect", "bank_forces", "suction", "bank_suction"), "compare": ("compare_models",),
    "estimate_model": ("from_dimensions", "from_particulars", "from_main_dimensions", "estimate", "estimate_ship"),
    "grounding_probability": ("grounding_risk", "probability_of_grounding"),
    "nondimensional": ("hydrodynamic_derivatives", "hydrodynamic_coefficients"),
    "zigzag": ("zigzag_test", "zig_zag"), "turning_circle": ("turning_test", "turn"),
    "export.write_c": ("export_c", "to_c"), "export.write_fmu": ("export_fmu", "to_fmu"), "Configuration": ("Config",),
}  # fmt: skip

# Functions with another meaning here, and what to write instead.
OTHER_FUNCTIONS: Rows = {
    "jacobian or control.linearize": ("linear",),
    "control.linearize(model, u=...).state_space()": ("state_space", "ss", "to_ss", "step_response", "bode"),
    "eigenvalues": ("stability", "is_stable"),
    "nondimensional": ("derivatives", "stability_derivatives"),
    "PAPER, SPEED, CROSSFLOW, MMG, or a name as in terms='speed'": ("tables", "terms_tables", "list_tables"),
    "measured_tests": ("datasets", "load_dataset", "example_data", "demo_tests", "load_kcs"),
    "read_captive, or measured_tests for tests of the package": ("load_data", "read_data"),
    "read_ship, or load_model for a model": ("read_toml", "load_toml"),
    "squat(model, u, formula=...)": ("barrass", "squat_barrass", "huuska", "icorels", "tuck", "sinkage"),
    "turning_circle or zigzag": ("manoeuvre", "maneuver", "spiral", "pullout"),
    "safe_envelope, or speed_limits along a waterway": ("safe_speed", "speed_limit", "max_speed"),
    "8 * 0.514444 for 8 knots: speeds are in m/s": ("knots", "kn", "knot", "kts", "KNOT", "units", "constants"),
    "estimation.Estimator": ("kalman", "Kalman", "ekf", "EKF", "filter", "estimator", "observer"),
    "`narrows monitor` in a terminal": ("monitor", "Monitor", "warning", "warn", "time_to_contact"),
    "Autopilot, or control.regulator": ("PID", "pid", "Pilot", "HeadingController"),
    "export.write_fmu": ("fmu",), "export.write_c": ("c_code",),
    "identify, whose left_out has the errors": ("cross_validate", "cross_val_score", "leave_one_out"),
    "help(nw), or narrows --help in a terminal": ("help", "docs", "examples", "tutorial"),
    "model.plot(), voyage.plot() or report.map_figure, by what is drawn": ("plot", "figure", "draw"),
    "published for models of papers, ready_ships for estimated ones": ("list_models", "models"),
    "safe_envelope(model).plot()": ("plot_envelope", "plot_safe_envelope", "envelope_chart"),
    "scale_model, by Froude's law": ("froude", "froude_scale", "froude_scaling"),
    "published": ("example_model", "demo", "demo_model", "load_example"),
    "ready_ships": ("known_ships",), "Configuration": ("Setup",),
    "estimate_model": ("model_from_dimensions", "ship_model", "make_model", "new_model"),
    "identify": ("curve_fit", "least_squares", "OLS"),
    "fit.bootstrap()": ("bootstrap", "resample"), "report.map_figure": ("plot_map", "draw_map"),
    "ensemble": ("map", "voyages"),
    "fit.std, fit.conf_int() or fit.covariance": ("uncertainty", "covariance", "std_error", "confidence_interval"),
    "fit.residuals or fit.plot_residuals()": ("residuals", "plot_residuals"), "fit.rsquared": ("r2", "rsquared"),
    "compare": ("aic", "bic"), "plan_tests": ("design_experiment", "optimal_design", "d_optimal"),
    "HarmonicRun or StraightRun": ("pmm", "PMM"),
    "squat(model, u), or safe_envelope(model) for the clearance": ("ukc", "under_keel_clearance"),
    "grounding_probability": ("risk",), "safe_envelope": ("operating_envelope",),
    "control.linearize(model, u=...).poles()": ("poles",),
    "turning_circle(model).tactical_diameter": ("tactical_diameter",), "export.write_matlab": ("to_matlab",),
    "voyage.animate()": ("animate", "animation"),
    "read_waterway": ("waterway_from_geojson",), "straight_waterway or read_waterway": ("channel", "canal_model"),
}  # fmt: skip

# Parts of subpackages by other libraries' names.
CONTROL: Rows = {
    "PredictiveHelm": ("nmpc", "NMPC"), "regulator, or nw.Autopilot": ("pid", "PID", "lqg", "pole_placement"),
    "nw.estimation.Estimator": ("kalman", "Kalman", "ekf", "ukf", "observer", "lqe"),
    "linearize(model, y=, u=).state_space()": ("ss", "StateSpace", "tf", "to_ss"),
}  # fmt: skip
ESTIMATION: Rows = {"Estimator": ("KalmanFilter", "kalman", "ekf", "EKF", "ExtendedKalmanFilter")}
# The same parts under another name.
SAME_PARTS: Rows = {
    "linearize": ("linearise", "linear_system"), "PredictiveHelm": ("mpc", "MPC"), "regulator": ("lqi", "LQI"),
    "Estimator": ("UnscentedKalmanFilter", "ukf", "UKF"), "consistency": ("nees", "NEES", "nis"),
    "write_fmu": ("fmu", "to_fmu"), "write_c": ("c", "to_c"), "write_page": ("page", "to_html"),
    "write_matlab": ("matlab", "to_matlab"),
}  # fmt: skip

# Verbs of the command line that are accepted under another name.
VERBS: Rows = {
    "identify": ("fit", "regress"), "simulate": ("sim", "run", "sail", "voyage"), "map": ("sweep", "ensemble"),
    "envelope": ("safe-envelope",), "trials": ("manoeuvres", "maneuvers"), "ships": ("list", "models"),
    "plan": ("design",), "demo": ("example",),
}  # fmt: skip

# Verbs with another meaning here, and what to write instead.
OTHER_VERBS: Rows = {
    "envelope": ("safe", "chart", "limits", "speed"),
    "trials": ("manoeuvre", "zigzag", "turn", "turning", "turning-circle", "turning_circle", "circle"),
    "monitor FILE": ("watch", "serve", "nmea", "warn"), "waterway": ("canal", "channel"), "demo": ("test",),
    "identify": ("train",),
    "explain MODEL TABLE": ("check", "compare", "report", "validate"), "learn": ("update", "log"),
    "export FORM MODEL": ("convert", "fmu"), "simulate --plot, map --plot or envelope --plot": ("plot", "draw", "show"),
    "simulate, whose voyages end where the hull touches bottom (in Python nw.squat(model, u))": ("squat", "sinkage"),
    "ships, and open a model's file in an editor": ("info", "describe", "inspect"),
}  # fmt: skip


def name_here(name: str, rows: Rows) -> str | None:
    """Return the name here of another library's name."""
    return next((ours for ours, theirs in rows.items() if name in theirs), None)


def remedy(name: str, rows: Rows, known: Iterable[str]) -> str:
    """Return what to write instead of an unknown name, as the end of a sentence."""
    meant = name_here(name, rows)
    return f"; write {meant}" if meant else near_miss(name, known)


def part_named(name: str, room: str, parts: Mapping[str, Any], rows: Rows) -> Any:
    """Return a part of a subpackage by another library's name; raise if there is none."""
    same = name_here(name, SAME_PARTS)
    if same and same in parts:
        return parts[same]
    raise AttributeError(f"nw.{room} has no {name!r}{remedy(name, rows, parts)}")


def public_name(name: str, known: Iterable[str]) -> str:
    """Return what to write instead of an unknown public name, as the end of a sentence."""
    longer = [word for word in sorted(known) if len(name) > 2 and name.lower() in word.lower()]
    meant = name_here(name, OTHER_FUNCTIONS) or " or ".join(longer)
    return f"; write {meant}" if meant else near_miss(name, known, NAMES_ALIKE)


def accept_aliases(function: Function) -> Function:
    """Accept the other names of a function's arguments, or of a class's fields; for a model, what has one."""
    if isinstance(function, type):
        function.__init__ = accept_aliases(function.__init__)  # type: ignore[misc]
        return function
    parameters = inspect.signature(function).parameters
    has_model = next(iter(parameters)) == "model"
    more = next((own.name for own in parameters.values() if own.kind is own.VAR_KEYWORD), "")
    any_name, positions = bool(more), more == "positions"  # Positions are those of actuators alone
    # A name can be that of two arguments (h: a step or a depth): the function has one of them.
    aliases = {
        name: ours
        for ours, theirs in reversed(tuple(ARGUMENTS.items()))
        if ours in parameters or (any_name and (not positions or ours == "rudder"))
        for name in theirs
    }

    own = function.__qualname__.removesuffix(".__init__")
    known = {*parameters, *(ARGUMENTS if any_name else ())}  # A fleet varies any quantity

    def has(row: str) -> bool:
        return any_name or row.split("=")[0] in parameters

    @wraps(function)
    def called(*values: Any, **given: Any) -> Any:
        for name in given.keys() - known:
            ours = aliases.get(name)
            if ours and ours not in given:
                given[ours] = given.pop(name)
            elif ours:
                raise InputError(f"{name} and {ours} are one argument; give {ours}")
            elif meant := name_here(name, {row: names for row, names in OTHER_ARGUMENTS.items() if has(row)}):
                raise InputError(f"{own} has no argument {name!r}; write {meant}")
        if has_model and values:
            values = (_model_of(values[0]), *values[1:])
        elif has_model and "model" in given:
            given["model"] = _model_of(given["model"])
        return function(*values, **given)

    return called  # type: ignore[return-value]


def _model_of(given: Any) -> Any:
    """Return a model: the one of a fit or of another result, or that of a file or a published name."""
    import narrows

    if isinstance(given, str | Path):
        return narrows.load_model(given)
    known = {*dir(type(given)), *getattr(type(given), "__dataclass_fields__", ())}
    return given if isinstance(given, narrows.Model) or "model" not in known else given.model
