"""Choice of the sensor model by its name in the parameters."""

from ppaas.costmap.map_layers import MapLayers
from ppaas.localization.likelihood_field import LikelihoodField, LikelihoodFieldProb
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.sensor_model import SensorModel
from ppaas.thread_budget import Threads

_FIELDS: dict[str, type[SensorModel]] = {
    "likelihood_field": LikelihoodField,
    "likelihood_field_prob": LikelihoodFieldProb,
}


def sensor_model(layers: MapLayers, parameters: AmclParameters, threads: Threads) -> SensorModel:
    """Return the sensor model named by ``laser_model_type``."""
    kind = _FIELDS.get(parameters.laser_model_type)
    if kind is None:
        # Rarely used: imported only here, so that not every container loads its kernels.
        from ppaas.localization.beam_model import BeamModel  # noqa: PLC0415

        kind = BeamModel
    return kind(layers, parameters, threads)
