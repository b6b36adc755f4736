"""Maps that mappings were drawn as, with their pose graphs."""

from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.maps.formats.map_files import save_map
from storage.ports import MapStore
from storage.records import MapRecord, Publication


def map_files(mapping: Mapping, name: str = "map") -> dict[str, bytes]:
    """Return the files of the map of a mapping, by part; the YAML file names ``NAME.pgm``."""
    yaml, image = save_map(draw_map(mapping.frames, mapping.frames.poses), f"{name}.pgm")
    return {"yaml": yaml, "image": image, "posegraph": b"".join(pack_mapping(mapping))}


def put_mapping(store: MapStore, map_id: str, mapping: Mapping, readers: tuple[str, ...] = ()) -> MapRecord:
    """Publish the map of a mapping for ann."""
    with store.stage() as upload:
        for part, data in map_files(mapping).items():
            upload.add(part, [data])
        return store.publish(upload, Publication(map_id, "ann", 1.0, readers=readers))
