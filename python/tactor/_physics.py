"""Physics of a program's own: a simulator in Python as the physics of a session."""
from __future__ import annotations

from typing import Any, Iterator, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _tactor
from ._errors import InputError
from ._graph import Time

Array = npt.NDArray[np.float64]
#: Where a body is and how it moves, by name: see `PhysicsLoop.result`.
Body = Mapping[str, npt.ArrayLike]
#: `{"force": [...], "torque": [...]}`, or 3 numbers of a force, or 6 of force and torque.
Wrench = Union[Mapping[str, npt.ArrayLike], npt.ArrayLike]

_FIXED = -1  # of a contact's `other`: a body that does not move


class Handle(NamedTuple):
    """The handle at one instant, in the world's frame W."""

    p_WD: Array  #: m, (3,)
    R_WD: Array  #: quaternion w, x, y, z, (4,)
    v_WD: Array  #: m/s, (3,)
    w_WD: Array  #: rad/s, (3,)
    buttons: int  #: a bit each


class ImplicitSpring(NamedTuple):
    """A spring and damper between handle and tool, for an engine that takes it implicitly."""

    k_t: float  #: N/m
    b_t: float  #: N s/m
    k_r: float  #: N m/rad
    b_r: float  #: N m s/rad


class ErpCfm(NamedTuple):
    """The same as a soft constraint, as the Open Dynamics Engine has it."""

    erp_t: float
    cfm_t: float  #: m/(N s)
    erp_r: float
    cfm_r: float  #: rad/(N m s)


class PhysicsStep:
    """What the next step of a program's physics needs. Frames: W world, D handle, T tool.

    The step goes from the sample of the handle at `begin` to that at `end`. The handle and the coupling are attributes.
    """

    def __init__(self, step: _tactor.PhysicsStep, loop: PhysicsLoop) -> None:
        self._step = step
        self._loop = loop
        #: s of the run, at which the last step ended.
        self.begin: float = step.begin
        #: s of the run, of the newest sample of the handle; the result holds for it.
        self.end: float = step.end
        #: s, from `begin` to `end`, above zero.
        self.h: float = step.h
        handle = self.handle()
        #: m, the handle at `end`, (3,).
        self.p_WD: Array = handle.p_WD
        #: The same, quaternion w, x, y, z, (4,).
        self.R_WD: Array = handle.R_WD
        #: m/s, (3,).
        self.v_WD: Array = handle.v_WD
        #: rad/s, (3,).
        self.w_WD: Array = handle.w_WD
        #: A bit for each button that is pressed.
        self.buttons: int = handle.buttons
        spring = step.implicit_spring()
        #: N/m, N s/m, N m/rad and N m s/rad of the coupling; zero where the graph has none.
        self.k_t, self.b_t, self.k_r, self.b_r = spring

    def handle(self, time: Optional[Time] = None) -> Handle:
        """The handle at `time` (s of the run), for sub-steps: on the straight way from `begin` to `end`; None: at `end`."""
        row, buttons = self._step.handle_at(time)
        return Handle(row[0:3], row[3:7], row[7:10], row[10:13], buttons)

    def implicit_spring(self, h: float = 0.0) -> ImplicitSpring:
        """The coupling as stiffness and damping, for an engine that takes a spring implicitly.

        With `h` = 0 they are as they are, for an engine that evaluates both at the end of its step. With `h` > 0 (s)
        the damping is b + h k, for an engine with steps of `h` that takes only the damping implicitly: then
        F = k (x_D - x) + (b + h k) (v_D - v'), with the handle where it is at the step's beginning, is implicit Euler.
        """
        return ImplicitSpring(*self._coupled().implicit_spring(h))

    def erp_cfm(self, h: float) -> ErpCfm:
        """The coupling as ERP and CFM of a constraint, for steps of `h` (s).

        erp = h k / (h k + b) and cfm = 1 / (h k + b), for a force as the multiplier (Open Dynamics Engine, manual,
        3.8.2); an engine whose multiplier is an impulse takes cfm / h. It is implicit Euler of the spring.
        """
        return ErpCfm(*self._coupled().erp_cfm(h))

    def wrench(self, p_WT: npt.ArrayLike, R_WT: Optional[npt.ArrayLike], v_WT: npt.ArrayLike,
               w_WT: Optional[npt.ArrayLike], mass: float, inertia: Optional[npt.ArrayLike], h: float, *,
               time: Optional[Time] = None) -> Tuple[Array, Array]:
        """The coupling's force (N) and torque (N m) on the tool, in W, for an engine that takes forces.

        `p_WT` (m, (3,)), `R_WT` (quaternion w, x, y, z), `v_WT` (m/s) and `w_WT` (rad/s) are the tool's. `mass` is in
        kg, `inertia` in kg m^2: a number, three principal ones or a matrix (3, 3). Of a tool that does not turn,
        `R_WT`, `w_WT` and `inertia` are None, and the torque is zero. `h` is the engine's step in s. `time` is that of
        the handle, as in `handle`.
        Raises InputError where such a force is not stable: h^2 k/m + 2 h b/m must be below 4, and so with the smallest
        principal inertia.
        """
        row = _row(_numbers("wrench: p_WT", p_WT, 3),
                   _numbers("wrench: R_WT", (1, 0, 0, 0) if R_WT is None else R_WT, 4),
                   _numbers("wrench: v_WT", v_WT, 3),
                   _numbers("wrench: w_WT", (0, 0, 0) if w_WT is None else w_WT, 3))
        smallest = 0.0 if inertia is None else _smallest_inertia(inertia)
        wrench = self._coupled().wrench(row, mass, smallest, h, time)
        return wrench[:3], wrench[3:]

    def _coupled(self) -> _tactor.PhysicsStep:
        if not self._loop._loop.has_coupling:
            name = self._loop.node
            raise InputError(f"coupling: the graph has no edge into {name}.coupling; add one, such as "
                             f"coupling.parameters -> {name}.coupling, or use a coupling of your own")
        return self._step

    def __repr__(self) -> str:
        return f"<tactor.PhysicsStep from {self.begin:g} s to {self.end:g} s>"


class PhysicsLoop:
    """A loop of physics that the program runs itself, for a graph with a node physics.external. See `Session.physics`.

        with tactor.Session("graph.yaml") as session:
            loop = session.physics()
            for step in loop:
                world.move(step)
                loop.result(step, tool={"p_WT": world.p, "v_WT": world.v})

    Under the virtual clock each step advances the run by one period of the node's `rate`. A result becomes visible one
    period after its step began, however long the program took. With `clock: real` the run goes by itself: a step is
    waited for until the next period begins, and a slow program is late physics.
    """

    def __init__(self, loop: _tactor.PhysicsLoop) -> None:
        self._loop = loop
        #: The name of the node in the graph.
        self.node: str = loop.node

    def next(self) -> Optional[PhysicsStep]:
        """The next step; starts the session if nobody has. None once the run has ended. Raises as `Session.advance`, and
        RunError at the end of a run in which no sample of the handle came, if its hand is a feed that nobody filled."""
        step = self._loop.next()
        return None if step is None else PhysicsStep(step, self)

    def __iter__(self) -> Iterator[PhysicsStep]:
        """The steps up to the run's end."""
        while (step := self.next()) is not None:
            yield step

    def result(self, step: PhysicsStep, tool: Optional[Body] = None, felt: Optional[Wrench] = None,
               contact: Optional[Wrench] = None, contacts: Optional[Any] = None, bodies: Optional[Any] = None,
               *, time: Optional[Time] = None) -> None:
        """Sends what `step` came to. Nothing is sent of what is None.

        `tool`: where the tool is: `p_WT` (m) and `v_WT` (m/s), and, if it turns, `R_WT` (quaternion w, x, y, z) and
        `w_WT` (rad/s). The graph's coupling makes the force of it.
        `felt`: the wrench on the device (N, N m, in W), where the program says itself what is felt.
        `contact`: the sum of the contacts on the tool about its origin (N, N m, in W).
        `contacts`: a list of mappings, or an array with these fields: `p_WC` (m, nearest point of the other body),
        `n_W` (unit normal from the other body towards the moving one), `distance` (m, negative inside), and the law:
        `stiffness` (N/m), `damping` (N s/m), `friction`; further `weight` (1), `inertia`, `creep`, `lift`, `p_TC` (the
        moving body's point in its own frame, at `distance` along `n_W` from `p_WC`; it follows from these), `H_W`,
        `body` (0: the tool) and `other` (-1: a fixed body). Needed where the graph reads contacts; [] says none is near.
        `bodies`: a list of mappings of all moving bodies, the tool first: `p_WB`, `v_WB`, and `R_WB`, `w_WB` if it
        turns. Needed where the scene has several.
        `time`: s of the run for which it holds; None: `step.end`.
        Raises InputError, which names the field, where something does not fit, and sends nothing then.
        """
        self._loop.result(step._step, time, None if tool is None else _body_row("result: tool", tool, "T"),
                          _wrench("result: felt", felt), _wrench("result: contact", contact),
                          None if contacts is None else _contacts(contacts),
                          None if bodies is None else _body_rows(bodies))

    def __repr__(self) -> str:
        return f"<tactor.PhysicsLoop of {self.node}>"


def _numbers(where: str, value: npt.ArrayLike, count: int) -> Array:
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{where}: expected {count} numbers, found {value!r}") from None
    if numbers.shape != (count,):
        raise InputError(f"{where}: expected {count} numbers, found an array of shape {numbers.shape}")
    return numbers


def _row(*parts: Array) -> Array:
    row: Array = np.concatenate(parts)
    return row


def _smallest_inertia(inertia: npt.ArrayLike) -> float:
    matrix = np.asarray(inertia, dtype=np.float64)
    if matrix.shape == (3, 3):
        return float(np.linalg.eigvalsh(matrix).min())
    if matrix.shape in ((), (3,)):
        return float(matrix.min())
    raise InputError(f"wrench: inertia: expected a number, 3 numbers or a matrix (3, 3), found shape {matrix.shape}")


def _check_keys(where: str, found: Sequence[str], known: Sequence[str], needed: Sequence[str]) -> None:
    for name in found:
        if name not in known:
            raise InputError(f"{where}: expected the fields {', '.join(known)}, found a field {name}")
    for name in needed:
        if name not in found:
            raise InputError(f"{where}: expected the fields {', '.join(needed)}, found none named {name}")


def _body_row(where: str, body: Body, frame: str) -> Tuple[Array, bool]:
    """The body's row, and whether it tells its rotation."""
    p, R, v, w = (name + frame for name in ("p_W", "R_W", "v_W", "w_W"))
    if not isinstance(body, Mapping):
        raise InputError(f"{where}: expected a mapping with {p}, {v} and, if it turns, {R} and {w}, found {body!r}")
    turns = R in body or w in body
    _check_keys(where, list(body), (p, R, v, w), (p, R, v, w) if turns else (p, v))
    row = _row(_numbers(f"{where}.{p}", body[p], 3), _numbers(f"{where}.{R}", body.get(R, (1, 0, 0, 0)), 4),
               _numbers(f"{where}.{v}", body[v], 3), _numbers(f"{where}.{w}", body.get(w, (0, 0, 0)), 3))
    return row, turns


def _body_rows(bodies: Any) -> Tuple[Array, npt.NDArray[np.bool_]]:
    rows = [_body_row(f"result: bodies[{i}]", body, "B") for i, body in enumerate(bodies)]
    return (np.array([row for row, _ in rows], dtype=np.float64).reshape(-1, 13),
            np.array([turns for _, turns in rows], dtype=np.bool_))


def _wrench(where: str, wrench: Optional[Wrench]) -> Optional[Array]:
    if wrench is None:
        return None
    if isinstance(wrench, Mapping):
        _check_keys(where, list(wrench), ("force", "torque"), ("force",))
        return _row(_numbers(f"{where}.force", wrench["force"], 3),
                    _numbers(f"{where}.torque", wrench.get("torque", (0, 0, 0)), 3))
    try:
        numbers = np.asarray(wrench, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape not in ((3,), (6,)):
        raise InputError(f"{where}: expected force and torque by name, or 3 or 6 numbers, found {wrench!r}")
    return _row(numbers, np.zeros(6 - len(numbers)))


_contact_dtype: Optional[np.dtype[Any]] = None


def _contacts(contacts: Any) -> Tuple[npt.NDArray[Any], npt.NDArray[np.int32], npt.NDArray[np.bool_]]:
    """The contacts, of each its two bodies, and whether it tells p_TC."""
    global _contact_dtype
    if _contact_dtype is None:
        _contact_dtype = _tactor.contact_dtype()
    fields = _contact_dtype.names or ()
    made = np.zeros(len(contacts), _contact_dtype)
    pairs = np.zeros((len(contacts), 2), np.int32)
    has_p_TC = np.zeros(len(contacts), np.bool_)
    for i, contact in enumerate(contacts):
        where = f"result: contacts[{i}]"
        dtype = getattr(contact, "dtype", None)
        names = list(contact) if isinstance(contact, Mapping) else list(dtype.names or ()) if dtype is not None else []
        _check_keys(where, names, (*fields, "body", "other"), ("p_WC", "n_W", "distance"))
        row = made[i:i + 1]
        row["weight"] = 1
        for name in names:
            if name in fields:
                shape = made.dtype[name].shape
                row[name] = _numbers(f"{where}.{name}", contact[name], shape[0]) if shape else _number(where, name, contact)
        pairs[i] = [_index(where, "body", contact, 0) if "body" in names else 0,
                    _index(where, "other", contact, _FIXED) if "other" in names else _FIXED]
        has_p_TC[i] = "p_TC" in names
    return made, pairs, has_p_TC


def _number(where: str, name: str, contact: Any) -> float:
    try:
        return float(contact[name])
    except (TypeError, ValueError):
        raise InputError(f"{where}.{name}: expected a number, found {contact[name]!r}") from None


def _index(where: str, name: str, contact: Any, low: int) -> int:
    number = _number(where, name, contact)
    if not low <= number < 1 << 30 or number != int(number):
        raise InputError(f"{where}.{name}: expected a whole number from {low}, found {contact[name]!r}")
    return int(number)
