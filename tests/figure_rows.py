"""Made-up rows for each kind of figure, with as many series as wanted, and their drawing."""

import warnings

import numpy as np
import pandas as pd

from vibrissa.figures import style
from vibrissa.figures.draw import KINDS
from vibrissa.study.axes import MOUNTING_AXES

THETA = np.linspace(1.0, 3.0, 9)


def combined(**axes):
    """All combinations of the values of some axes, as rows."""
    return pd.MultiIndex.from_product(axes.values(), names=axes).to_frame(index=False)


def slipping(rows):
    """Made-up results at grid points: an onset that bends up to a lock as a square root."""
    lock = rows.eval("0.7 - 0.07 * theta - 0.2 * eta")
    gap = (lock - rows.mu0).clip(lower=0.0)
    onset = 0.1 * rows.theta * (1.0 - np.sqrt(gap / lock)) * (1.2 - rows.eta)
    slips = gap > 0.0
    return rows.assign(
        status=np.where(slips, "slip", "lock"),
        message="",
        contact=np.where(rows.mu0 > 0.5 * lock, "line", "point"),
        ends_by=np.where(rows.theta > 2, "slips_back", "snaps"),
        mu_lock=lock,
        x0_lock=0.1 * rows.theta * (1.2 - rows.eta),
        x0_slip=onset.where(slips),
        n_steps=(onset // rows.dx0).where(slips),
        x0_max=(onset // rows.dx0 * rows.dx0).where(slips),
        penetrates=rows.theta > 2.5,
    )


def taper(count):
    return slipping(
        combined(theta=THETA, mu0=np.linspace(0.05, 0.45, count), eta=[0.85], dx0=[0.001])
    )


def friction(count):
    return slipping(
        combined(theta=[2.0], mu0=np.linspace(0.05, 0.5, count), eta=[0.85], dx0=[0.0005])
    )


def plane(count):
    axes = {"theta": THETA, "mu0": np.linspace(0.1, 0.7, 7), "eta": np.linspace(0.3, 0.9, count)}
    return slipping(combined(**axes, dx0=[0.001]))


def near_locks(count):
    axes = {"theta": np.linspace(1.0, 3.0, count), "mu0": np.linspace(0.2, 0.5, 31)}
    return slipping(combined(**axes, eta=[0.85], dx0=[0.001]))


def past_locks(count):
    """As near the locks and beyond, where the end of sticking jumps up."""
    rows = near_locks(count)
    locks = rows.status == "lock"
    return rows.assign(
        ends_by=np.where(locks, "swings_aside", None),
        x0_end=(4.0 * rows.x0_lock).where(locks),
        x0_trail=(8.0 * rows.x0_lock + 0.02 * rows.mu0).where(locks),
    )


def mounted(count):
    axes = {"theta": np.linspace(1.0, 3.0, count), "clamp_angle": np.linspace(-0.1, 0.1, 5)}
    rows = slipping(combined(**axes, mu0=[0.2], eta=[0.85], dx0=[0.001]))
    return in_mountings(rows, 0.0)


def in_mountings(rows, ideal):
    """Made-up results that follow the inclination of the clamp; all else is ideal."""
    forces = {f"reaction_{name}_slip": rows.theta * rows.clamp_angle for name in ("fx", "fy", "m")}
    lock = rows.mu_lock - rows.clamp_angle * (1.0 - ideal * rows.theta)
    others = dict.fromkeys(set(MOUNTING_AXES) - {"clamp_angle"}, 0.0)
    return rows.assign(**forces, **others).assign(mu_lock=lock)


def of_slopes(count):
    axes = {"theta": np.linspace(1.0, 3.0, min(count, 4)), "clamp_angle": np.linspace(-0.1, 0.1, 5)}
    etas = np.linspace(0.3, 0.9, min(count, 6))
    rows = slipping(combined(**axes, eta=etas, mu0=[0.2], dx0=[0.001]))
    rows = in_mountings(rows, 0.0).assign(grid="leaning")
    return rows.assign(x0_slip=rows.x0_slip * (1.0 + 30.0 * rows.clamp_angle**2 * rows.theta))


def deviating(count):
    axes = {"theta": THETA, "eta": np.linspace(0.3, 0.9, count), "clamp_angle": [0.0, 0.02]}
    return in_mountings(slipping(combined(**axes, mu0=[0.2], dx0=[0.001])), 0.0)


def against_cylinders(count):
    tapers = np.linspace(1.0, 4.0, min(max(count, 3), 12))
    axes = {"theta": tapers, "eta": np.linspace(0.3, 0.9, count)}
    rows = combined(**axes, clamp_angle=np.linspace(-0.2, 0.2, 5), mu0=[0.2], dx0=[0.001])
    return in_mountings(slipping(rows), 1.0)


def shapes(begins, bends):
    """Rods from a clamp at each x0, bent the more the farther it is from the tip."""
    height = np.linspace(0.0, 0.85, 30)
    bent = [begin + bend * (height / 0.85) ** 2 for begin, bend in zip(begins, bends, strict=True)]
    return {"shape_x": bent, "shape_y": [height] * len(bent)}


def cycles(count):
    rows = combined(cycle=range(1, count + 1), x0=np.linspace(0.0, 0.05, 6))
    footpoint = 0.05 * (rows.cycle - 1) + rows.x0
    return rows.assign(
        theta=2.0,
        mu0=0.3,
        eta=0.85,
        dx0=0.01,
        status="slip",
        phase="stick",
        footpoint=footpoint,
        x1=0.45 + 0.05 * (rows.cycle - 1),
        alpha=-np.arctan(6.0 * rows.x0),
        stability=1.0 - rows.x0,
        stability_aside=0.5 - rows.x0,
        s_c=1.0,
        reaction_fx=rows.x0,
        reaction_fy=-1.0,
        reaction_m=0.5 - rows.x0,
        **shapes(footpoint, 0.45 - rows.x0),
    )


def slipping_once(count):
    """Scans of more and more cycles, each of which ends with a slip."""
    rows = cycles(max(count, 2))
    is_slip = (rows.x0 == 0.0) & (rows.cycle > 1)
    rows["cycle"] -= is_slip.astype(int)
    return rows.assign(
        phase=np.where(is_slip, "slip", "stick"), shape_phi=[np.full(30, 1.2)] * len(rows)
    )


def swung(count, per_scan=40):
    """First periods of rods of several tapers that swing aside half-way, at their own places."""
    rows = combined(theta=np.linspace(1.0, 3.0, count), step=range(per_scan))
    over = 0.5 / rows.theta
    footpoint = 2.0 * over * rows.step / (per_scan - 1)
    ahead = over - footpoint
    turned = np.where(ahead > 0.0, 1.0, -1.0)
    (bent,) = shapes([0.0], [0.3])["shape_x"]
    return rows.assign(
        mu0=0.9,
        eta=0.85,
        dx0=0.01,
        status="lock",
        cycle=1,
        phase="stick",
        footpoint=footpoint,
        x1=over,
        s_c=1.0,
        phi1=np.where(ahead > 0.0, 0.3, np.pi - 0.3),
        stability=0.7 + ahead.abs(),
        stability_aside=ahead.abs(),
        shape_x=[at + way * bent for at, way in zip(footpoint, turned, strict=True)],
        shape_y=shapes(footpoint, footpoint)["shape_y"],
    )


def vibrating(count):
    """First periods with natural frequencies."""
    rows = swung(count)
    first = 40.0 / rows.theta - rows.footpoint
    return rows.assign(frequency_1=first, frequency_2=2.5 * first)


def vibrating_at_onset(count):
    """Natural frequencies at the onsets of slip."""
    rows = taper(count)
    first = (40.0 / rows.theta - rows.mu0).where(rows.status == "slip")
    return rows.assign(frequency_1=first, frequency_2=2.5 * first)


def swinging(count):
    """One rod in more and more steps."""
    return swung(1, 2 * count)


def states(count):
    x1 = np.linspace(0.05, 0.5, count)
    return pd.DataFrame(
        {
            "state": [f"state_{i}_with_a_rather_long_name_{i}" for i in range(count)],
            "theta": 1.0,
            "eta": 0.85,
            "x1": x1,
            "status": "solved",
            "message": "",
            "contact": "point",
            "f": 2.7,
            "alpha": -0.1,
            "phi1": 0.4,
            "s_c": 1.0,
            "penetrates": x1 < 0.2,
            **shapes(np.zeros(count), x1),
        }
    )


def both_contacts(count):
    return made_comparison(combined(theta=THETA, mu0=np.linspace(0.05, 0.5, count), eta=[0.85]))


def made_comparison(rows):
    """Made-up results in both kinds of contact, in which every tip slips."""
    return rows.assign(
        status_point="slip",
        status_line="slip",
        x0_slip_point=0.1 * rows.theta * (1.0 + rows.mu0),
        x0_slip_line=0.1 * rows.theta,
        penetrates=rows.theta > 2.0,
        mu_lock_point=0.5,
        mu_lock_line=0.5 - 0.1 * (rows.theta - 1.0),
    )


def heights(count):
    axes = {"theta": np.linspace(1.0, 3.0, count), "eta": np.linspace(0.6, 0.9, 7)}
    return slipping(combined(**axes, mu0=[0.3], dx0=[0.001]))


def laws(count):
    """Periods by each law, of which the law free has no ratio."""
    ratios = np.linspace(0.4, 0.9, count)
    scans = [("free", np.nan), *((law, k) for law in ("energy", "kinetic") for k in ratios)]
    rows = pd.DataFrame(scans, columns=["law", "kinetic_ratio"])
    rows = rows.merge(pd.DataFrame({"period": [1, 2, 3]}), how="cross")
    travel = 0.03 * rows["kinetic_ratio"].fillna(1.0) + 0.001 * rows["period"]
    return rows.assign(
        ends_by="slip",
        status="slip",
        travel=travel,
        slip_length=travel + 0.001,
        reaction_fx_onset=-travel,
        reaction_fx_rest=0.0,
    )


def teeth(count):
    """Loads that grow and fall, by each law with another period."""
    parts = []
    for law, teeth in zip(
        ("energy", "free", "kinetic"), (count, count + 1, 2 * count), strict=True
    ):
        footpoint = np.arange(201) * 0.002
        phase = teeth * footpoint / 0.4
        load = phase % 1.0
        columns = {"footpoint": footpoint, "cycle": 1 + phase.astype(int), "reaction_fx": -load}
        parts.append(pd.DataFrame(columns).assign(law=law, dx0=0.002))
    return pd.concat(parts)


def readings(count):
    """Recordings of rods of several heights, some without an estimate or beside the truth."""
    generator = np.random.default_rng(1)
    points = [(theta, eta) for eta in np.linspace(0.8, 0.9, count) for theta in (1.0, 2.0, 4.0)]
    rows = pd.DataFrame([point for point in points for _ in range(4)], columns=["theta", "eta"])
    stated = 0.005 + 0.002 * rows["theta"]
    names = ["surface_slope", "transducer_angle", "length", "eta", "theta", "creep", "modulus", "x"]
    return rows.assign(
        readings="tapers",
        status=np.where(rows.index % 7, "read", "refused"),
        grade=None,
        mu0_true=0.3,
        mu0_read=(0.3 + stated * generator.normal(size=len(rows))).where(rows.index % 7 > 0),
        mu0_deviation=stated,
        mu0_random=0.6 * stated,
        mu0_common=0.8 * stated,
        inside=[place % 5 != 0 if place % 7 else None for place in rows.index],
        period_error=1.1 * stated,
        period_deviation=1.2 * stated,
        predicted=1.3 * stated,
        way=0.048,
        limit_name=[names] * len(rows),
        limit_share=[[0.5 / (place + theta) for place in range(8)] for theta in rows["theta"]],
    )


# Keys that a figure has in the study file, if its kind needs them.
GIVEN = {
    "accuracy": {"over": "theta", "by": "eta"},
    "coverage": {"over": "theta", "by": "eta"},
    "uncertainty": {"over": "theta", "by": "eta"},
    "limits": {"over": "theta"},
    "onset": {"over": "eta", "by": "theta"},
    "map": {"over": "eta", "by": "theta"},
    "periods": {"over": "kinetic_ratio", "by": "law"},
    "sawtooth": {"by": "law"},
    "spectrum": {"by": "law"},
}
ROWS = {
    "accuracy": readings,
    "coverage": readings,
    "uncertainty": readings,
    "limits": readings,
    "onset": heights,
    "map": heights,
    "periods": laws,
    "sawtooth": teeth,
    "spectrum": teeth,
    "taper": taper,
    "friction": friction,
    "locking": plane,
    "regimes": plane,
    "law": near_locks,
    "past_lock": past_locks,
    "margins": swung,
    "frequencies": vibrating_at_onset,
    "ringing": vibrating,
    "swing": swinging,
    "mounting": mounted,
    "slopes": of_slopes,
    "change": deviating,
    "versus": against_cylinders,
    "scan": cycles,
    "period": cycles,
    "slip": slipping_once,
    "signals": cycles,
    "state": states,
    "models": both_contacts,
}


def drawn(kind, count):
    with style.applied(), warnings.catch_warnings():
        # Such as matplotlib's when type leaves no room for the axes.
        warnings.simplefilter("error")
        return KINDS[kind].plot(ROWS[kind](count), **GIVEN.get(kind, {}))
