"""Parameters of the planner plug-ins: NavFn, Smac 2D, hybrid and lattice, Theta*."""

from ppaas.imports.parameters.nav2.reasons import SHOWN
from ppaas.imports.parameters.nav2.tables import Given, PluginTable, rules_of
from ppaas.imports.parameters.rules import Convert
from ppaas.imports.parameters.values import flag, number, one_of, whole

GOAL_HEADING = "the path ends in the heading of the goal"
OWN_SMOOTHING = "the parameter smooth of a grid planner smooths, smooth_path that of lattice"
OWN_SEARCH = "the search has its own heuristic and no such limit"
CELLS = "plans have the cells of the map"

SMOOTHER = (
    "smoother.max_iterations smoother.w_smooth smoother.w_data smoother.tolerance smoother.do_refinement "
    "smoother.refinement_num"
)

_EARLIER_SMOOTHER = (
    "smoother.smoother.w_curve smoother.smoother.w_dist smoother.smoother.w_smooth smoother.smoother.w_cost "
    "smoother.smoother.cost_scaling_factor smoother.optimizer.max_time smoother.optimizer.max_iterations "
    "smoother.optimizer.debug_optimizer smoother.optimizer.gradient_tol smoother.optimizer.fn_tol "
    "smoother.optimizer.param_tol smoother.optimizer.advanced.min_line_search_step_size "
    "smoother.optimizer.advanced.max_num_line_search_step_size_iterations "
    "smoother.optimizer.advanced.line_search_sufficient_function_decrease "
    "smoother.optimizer.advanced.max_num_line_search_direction_restarts "
    "smoother.optimizer.advanced.max_line_search_step_expansion"
)
"""Parameters of the smoother of Foxy and Galactic."""

_TOLERANCE: dict[str, Given] = {"tolerance": ("move_base.default_tolerance", number)}

NAVFN = PluginTable(
    "nav2_navfn_planner::NavfnPlanner",
    rules_of(
        "navfn",
        "use_astar allow_unknown",
        _TOLERANCE,
        {GOAL_HEADING: "use_final_approach_orientation", OWN_SEARCH: "max_cycles_factor"},
        {"use_astar": flag, "allow_unknown": flag},
    ),
    becomes="navfn",
)

SMAC_2D = PluginTable(
    "nav2_smac_planner::SmacPlanner2D",
    rules_of(
        "astar",
        "allow_unknown",
        {**_TOLERANCE, "max_planning_time": ("move_base.planner_timeout", number)},
        {
            GOAL_HEADING: "use_final_approach_orientation",
            OWN_SMOOTHING: f"{SMOOTHER} {_EARLIER_SMOOTHER} smooth_path",
            "it searches without headings": (
                "angle_quantization_bins reverse_penalty change_penalty non_straight_penalty cost_penalty "
                "retrospective_penalty analytic_expansion_ratio analytic_expansion_max_length lookup_table_size "
                "cache_obstacle_heuristic"
            ),
            OWN_SEARCH: (
                "max_iterations max_on_approach_iterations terminal_checking_interval motion_model_for_search "
                "minimum_turning_radius"
            ),
            CELLS: "downsample_costmap downsampling_factor",
            "cells weigh 50 + 0.8 times their cost": "cost_travel_multiplier",
        },
        {"allow_unknown": flag},
    ),
    becomes="astar",
)

_LATTICE_SAME = (
    "allow_unknown tolerance max_iterations max_planning_time analytic_expansion_ratio analytic_expansion_max_length "
    "reverse_penalty change_penalty non_straight_penalty cost_penalty retrospective_penalty smooth_path"
)
_HYBRID_SAME = (
    f"{_LATTICE_SAME} motion_model_for_search minimum_turning_radius angle_quantization_bins "
    "allow_primitive_interpolation"
)
_LATTICE_CONVERT: dict[str, Convert] = {
    **dict.fromkeys(_HYBRID_SAME.split(), number),
    **dict.fromkeys(("allow_unknown", "smooth_path", "allow_primitive_interpolation"), flag),
    **dict.fromkeys(("max_iterations", "angle_quantization_bins"), whole),
    "motion_model_for_search": one_of({name: name for name in ("DUBIN", "REEDS_SHEPP")}),
}

_LATTICE_NONE = {
    OWN_SEARCH: (
        "max_on_approach_iterations terminal_checking_interval lookup_table_size cache_obstacle_heuristic "
        "analytic_expansion_max_cost analytic_expansion_max_cost_override use_quadratic_cost_penalty "
        "downsample_obstacle_heuristic obstacle_heuristic_downsampling"
    ),
    OWN_SMOOTHING: f"{SMOOTHER} {_EARLIER_SMOOTHER}",
    SHOWN: "debug_visualizations viz_expansions",
    "a goal has one heading": "goal_heading_mode coarse_search_resolution",
}

SMAC_HYBRID = PluginTable(
    "nav2_smac_planner::SmacPlannerHybrid",
    rules_of(
        "lattice",
        _HYBRID_SAME,
        {},
        {**_LATTICE_NONE, CELLS: "downsample_costmap downsampling_factor"},
        _LATTICE_CONVERT,
    ),
    becomes="lattice",
)

SMAC_LATTICE = PluginTable(
    "nav2_smac_planner::SmacPlannerLattice",
    rules_of(
        "lattice",
        _LATTICE_SAME,
        {
            "allow_reverse_expansion": (
                "motion_model_for_search",
                lambda value: "REEDS_SHEPP" if flag(value) else "DUBIN",
            )
        },
        {
            **_LATTICE_NONE,
            "motions are computed from minimum_turning_radius": "lattice_filepath",
            "paths have no turns in place": "rotation_penalty",
        },
        _LATTICE_CONVERT,
    ),
    becomes="lattice",
)

THETA_STAR = PluginTable(
    "nav2_theta_star_planner::ThetaStarPlanner",
    rules_of(
        "theta_star",
        "allow_unknown",
        _TOLERANCE,
        {
            GOAL_HEADING: "use_final_approach_orientation",
            OWN_SEARCH: "how_many_corners w_heuristic_cost terminal_checking_interval",
            "cells weigh 50 + 0.8 times their cost": "w_euc_cost w_traversal_cost",
        },
        {"allow_unknown": flag},
    ),
    becomes="theta_star",
)

PLANNERS = (NAVFN, SMAC_2D, SMAC_HYBRID, SMAC_LATTICE, THETA_STAR)
