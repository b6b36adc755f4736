"""Bare parses: what the library of a format alone takes for a file, without a check of its content."""

import io

import msgspec
import yaml

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def yaml_tree(content: bytes) -> object:
    """Parse YAML by PyYAML, with libyaml where it is installed."""
    return yaml.load(content, Loader=_LOADER)


def json_tree(content: bytes) -> object:
    """Parse JSON by msgspec."""
    return msgspec.json.decode(content)


def las_points(content: bytes) -> object:
    """Read the points of LAS or LAZ by laspy."""
    import laspy  # noqa: PLC0415 - of the extra of clouds

    return laspy.read(io.BytesIO(content)).xyz


def raster_bands(content: bytes) -> object:
    """Read the bands of a raster by rasterio."""
    import rasterio  # noqa: PLC0415 - of the extra of GIS

    with rasterio.MemoryFile(content) as memory, memory.open() as source:
        return source.read()


def dxf_drawing(content: bytes) -> object:
    """Read a drawing in text by ezdxf."""
    from ezdxf.filemanagement import read  # noqa: PLC0415 - of the extra of drawings

    return read(io.StringIO(content.decode("utf-8", "surrogateescape")))


def svg_picture(content: bytes) -> object:
    """Render an SVG in its own size by resvg."""
    import resvg_py  # noqa: PLC0415 - of the extra of drawings

    return resvg_py.svg_to_bytes(svg_string=content.decode(), skip_system_fonts=True)
