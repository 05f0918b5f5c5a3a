"""Reads what an emulated Modbus motor logged (tactor-emulate-modbus --log): its own account, by the steps of its motion."""
import collections

Row = collections.namedtuple("Row", "time_ns position_m force_N commanded_N expired commands given_J")


def motor_log(path):
    """All whole rows so far; the last one may be cut. Energy is net, from the motor to the hand."""
    rows = [line.split() for line in path.read_text().splitlines()] if path.exists() else []
    return [Row(*map(float, row)) for row in rows if len(row) == len(Row._fields)]
