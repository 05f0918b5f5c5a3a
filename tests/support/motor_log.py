"""Reads what an emulated Modbus motor logged (tactor-emulate-modbus --log): its own account, by the steps of its motion."""
import collections

Row = collections.namedtuple("Row", "time_ns position_m force_N commanded_N expired commands given_J")


def motor_log(path):
    """All whole rows so far; the last one may be cut. A row of other columns raises TypeError. Energy is net, from motor to hand."""
    whole = path.read_text().split("\n")[:-1] if path.exists() else []
    return [Row(*map(float, row.split())) for row in whole]
