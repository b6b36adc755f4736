"""Starts of a plan: the cell in which it begins for each robot, and the cells that it leaves out."""

from collections import Counter
from collections.abc import Collection

from ppaas.traffic.members import Cell, Member
from ppaas.traffic.occupancy import Occupancy
from ppaas.traffic.sizes import REACH


def heads_of(occupancy: Occupancy) -> dict[str, Cell]:
    """Return the cells at the ends of ways; robots without a way get the nearest cell that nobody else has.

    Of robots that report ways to one cell, one is wrong: all of them are asked to give back the rest of their ways.
    """
    joined = [member for member in occupancy.members.values() if member.standing == "joined" and not member.misfit]
    ends = Counter(member.chain[-1] for member in joined if member.chain)
    occupancy.gives_back |= {member.name for member in joined if member.chain and ends[member.chain[-1]] > 1}
    heads = {member.name: member.chain[-1] for member in joined if member.chain and ends[member.chain[-1]] == 1}
    taken = set(ends)
    for member in joined:
        if not member.chain:
            near = cells_near(occupancy, member)
            free = [cell for cell in near if cell not in taken and not _is_granted(occupancy, cell, member.name)]
            if free:
                heads[member.name] = free[0]
                taken.add(free[0])
    return heads


def cells_near(occupancy: Occupancy, member: Member) -> list[Cell]:
    """Return the cells to which a robot without a way may be led, the nearest one first."""
    report, cells = member.report, occupancy.cells
    return cells.nearby(report.x, report.y, REACH * cells.spacing, occupancy.size_of(member))


def _is_granted(occupancy: Occupancy, cell: Cell, but: str) -> bool:
    return any(cell in occupancy.members[name].chain for name in occupancy.holders[cell] - {but})


def obstacles_in(occupancy: Occupancy, heads: Collection[str]) -> set[Cell]:
    """Return the cells that are not planned: where something was found, and cells of robots without a head."""
    aside = (member.held for name, member in occupancy.members.items() if name not in heads)
    return set(occupancy.blocked).union(*aside)
