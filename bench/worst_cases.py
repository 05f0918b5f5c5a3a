"""Where Tactor fails, by numbers read from the pages of results: what docs/trust/limits.md begins with.

`scripts/limits --worst` writes it anew after a page of results has changed.
"""
import re

import page
from run_time import table

NUMBER = re.compile(r"-?\d[\d,]*\.?\d*(?:e[+-]?\d+)?")


def tables(text):
    """[(heading, [{column: cell}])]: each table of a Markdown page with the heading that it stands under."""
    found, heading, rows = [], "", None
    for line in text.splitlines():
        if line.startswith("#"):
            heading, rows = line.lstrip("# "), None
        elif not line.startswith("|"):
            rows = None
        else:
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            if rows is None:
                head, rows = cells, []
                found.append((heading, rows))
            elif not set(line) <= set("|-: "):
                rows.append(dict(reversed(list(zip(head, cells)))))  # of two columns without a name the first
    return found


def under(name, heading):
    """The rows of all tables of docs/NAME.md under a heading. Raises ValueError where there is none."""
    rows = [row for title, found in tables((page.ROOT / f"docs/{name}.md").read_text()) if title == heading for row in found]
    if not rows:
        raise ValueError(f"docs/{name}.md has no table under \"{heading}\"")
    return rows


def number(cell):
    """The first number of a cell: 0.77 of `0.77 (star_sweep)`."""
    return float(NUMBER.search(cell).group().replace(",", ""))


def one(rows, column, value):
    """The row whose column has this value."""
    return next(row for row in rows if row[column].strip("`") == value)


def scenes(method):
    """How a method fares on its worst scene, of new draws and of the development, against a hold."""
    new, old = (one([row for row in under("results/transfer_results", heading) if "worst scene" in row], "method", method)
                for heading in ("Scenes that are new", "Scenes of the development"))
    return new, old


def scene_rows():
    where = "[transfer](../results/transfer_results.md)"
    new, old = scenes("local")
    worst = max(new, old, key=lambda row: number(row["worst scene"]))
    yield ["`local` on its worst scene", f"It gains little: {worst['worst scene']} times the error of a hold. In the mean it has {new['mean']} times", where]
    new, old = scenes("blend")
    yield ["`blend` on its worst scenes", f"It is worse than a hold: {new['worst scene']} and {old['worst scene']} times its error, and worse by 5 % on "
           f"{new['scenes worse than hold by 5 %']} of new scenes", where]
    new, _ = scenes("fixed")
    yield ["`fixed` coefficients", f"They are worse than a hold on {new['scenes worse than hold by 5 %']} of new scenes", where]


def soft_rows():
    where = "[deformable](../results/deformable_results.md)"
    said = [row for heading, rows in tables((page.ROOT / "docs/results/deformable_results.md").read_text()) for row in rows if "error / hold" in row]
    worst = max((row for row in said if row["method"] == "`blend`"), key=lambda row: number(row["error / hold"]))
    yield ["`blend` on soft bodies", f"It is worse than a hold: {worst['error / hold']} times its error on {worst['scene']}", where]
    cost = under("results/deformable_results", "What a result costs")
    slow = max(cost, key=lambda row: number(row["p99, us"]))
    late = max(cost, key=lambda row: number(row["share of the period, %"]))
    yield ["ticks of `local` on soft bodies", f"99 of 100 take up to {slow['p99, us']} us of the 1,000 us that there are ({slow['scene']}, {slow['tetrahedra']} "
           "tetrahedra)", where]
    yield ["physics of soft bodies", f"A result takes {late['share of the period, %']} % of its declared period ({late['scene']}, {late['tetrahedra']} "
           f"tetrahedra at {late['rate, Hz']} Hz): it cannot keep that rate", where]


def hand_rows():
    where = "[stability](../results/stability.md#hands)"
    rows = under("results/stability", "Hands")
    bare = [row for row in rows if "worst, any" in row][:7]  # the first table: without friction
    for method in ("hold", "paper", "blend", "local"):
        row = one(bare, "method", method)
        yield [f"`{method}` in a hand, device without friction", f"A light finger makes it swing above {row['finger']} N/m, the worst passive hand found "
               f"{above(row['worst, any'])}", where]


def above(cell):
    """`above 25 N/m`, or that the softest coupling tried is too stiff."""
    return f"at every coupling tried, down to {number(cell):g} N/m" if cell.startswith("under") else f"above {cell} N/m"


def energy_rows():
    where = "[passivity](../explanation/passivity.md#what-is-promised-and-for-which-hand)"
    for heading, said in (("Energy, live", "with physics near"), ("Energy, live, with physics away", "with physics 10 and 50 ms away")):
        bound = [row for row in under("explanation/passivity", heading) if row["stage"].endswith("`energy_bound`")]
        held, cells = (sum(int(row["cells within the bound"].split(" of ")[i]) for row in bound) for i in (0, 1))
        worst = max(number(row["largest share"]) for row in bound)
        yield [f"the energy bound, live, {said}", f"It held in {held} of {cells} cells; the worst gave {worst:g} times what is allowed", where]


def other_rows():
    rows = under("results/truth_results", "MuJoCo, contact of the size of our scenes' 2 N/mm")
    worst = max(rows, key=lambda row: number(row["local"]))
    yield ["`local` against another engine's truth", f"It errs {worst['local']} times as much as our own physics at 1 kHz does (`{worst['scene']}`), in its worst "
           f"seed {worst['local, worst seed'].split()[0]} times", "[truth](../results/truth_results.md)"]
    busy = under("results/live_results", "Every core busy with other work: 10 minutes of each")
    late, missed, ticks = (one(busy, "", name)["tactor"] for name in ("wake-up max, us", "missed ticks", "ticks"))
    yield ["the device's loop on a busy virtual machine", f"It woke up to {number(late) / 1000:.3g} ms late and missed {missed} of {ticks} ticks, as "
           "`cyclictest` did beside it", "[live](../results/live_results.md)"]
    task = max(under("results/cluster_results", "A task and a run"), key=lambda row: number(row["with the scheduler, %"]))
    yield ["a study of short runs on a cluster", f"{task['with the scheduler, %']} % of the time is not in runs, where a run takes {task['a run takes, s']} s",
           "[cluster](../results/cluster_results.md)"]


def text():
    """The table, with a row for each failure."""
    return table(["what", "how it fails", "measured in"], [*scene_rows(), *soft_rows(), *hand_rows(), *energy_rows(), *other_rows()])
