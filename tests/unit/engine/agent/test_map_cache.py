import asyncio
import math
import resource
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.agent import map_cache
from engine.agent.layer_builder import LayerBuilder
from engine.agent.layer_jobs import GridFiles, build_here
from engine.agent.map_cache import Builder, MapCache
from engine.container.current_map import SharedIndexes
from engine.specs.containers import LayerSpec, MapVersion
from engine.specs.layer_files import open_layers
from ppaas.costmap.build_layers import build_layers, recosted
from ppaas.costmap.global_parameters import CostParameters
from ppaas.errors import InvalidMap, InvalidParameter, InvalidPlanner, NotFound, Unavailable
from ppaas.maps.formats.map_files import load_map
from ppaas.planners.hub_labels.planner import HubLabels
from tests.support.sources import ROOT
from tests.support.storage.records import YAML, GivenMap, found_map, house, kept, pgm, put_map
from tests.support.waiting import patience


class FakeBuilder:
    """Builder that writes one file when the test allows it."""

    def __init__(self):
        self.built: list[str] = []
        self.failures: list[BaseException] = []
        self.go = asyncio.Event()
        self.go.set()

    async def __call__(self, spec: LayerSpec, folder: Path) -> None:
        await self.go.wait()
        if self.failures:
            raise self.failures.pop()
        self.built.append(spec.map.id)
        (folder / "layers").write_text(f"{spec.map.version} {spec.robot_radius}")


@pytest.fixture
def building() -> FakeBuilder:
    return FakeBuilder()


@pytest.fixture
def cache(tmp_path, building) -> MapCache:
    return MapCache(tmp_path / "shm", build=building, spare=2)


class FakeIndexer:
    """Indexer that writes one file when the test allows it."""

    def __init__(self):
        self.made: list[str] = []
        self.failures: list[BaseException] = []
        self.go = asyncio.Event()
        self.go.set()

    async def __call__(self, folder: Path, planner: str) -> None:
        self.made.append(planner)
        await self.go.wait()
        if self.failures:
            raise self.failures.pop()
        (folder / f"{planner}.index").write_text("made")


@pytest.fixture
def indexing() -> FakeIndexer:
    return FakeIndexer()


@pytest.fixture
def indexed(tmp_path, building, indexing) -> MapCache:
    return MapCache(tmp_path / "shm", build=building, index=indexing, spare=0)


def folders(cache: MapCache) -> list[str]:
    return sorted(folder.name.partition("@")[0] for folder in cache._root.iterdir())


def build_in_thread(folder: Path, given: GivenMap) -> Builder:
    """Build the layers of a map in this process, from files written to a folder."""
    for name, data in given.files.items():
        (folder / name).write_bytes(data)

    async def build(spec: LayerSpec, layers: Path) -> None:
        files = GridFiles(str(folder / "yaml"), str(folder / "image"), given.created)
        await asyncio.to_thread(build_here, spec, files, {}, layers)

    return build


async def test_real_layers_are_built_and_opened(tmp_path):
    record = house(image=pgm(40, 30))
    cache = MapCache(tmp_path / "shm", build=build_in_thread(tmp_path, record))
    folder = await cache.ensure(LayerSpec(record, 0.18))
    layers = open_layers(folder)
    assert layers.grid.data.shape == (30, 40)
    assert layers.costmap.data.max() == 0  # an empty house


async def test_forked_process_builds_the_same_layers(tmp_path):
    record = house(image=b"P5\n40 30\n255\n" + bytes([254] * 600 + [0] * 5 + [205] * 595))
    here = await MapCache(tmp_path / "a", build=build_in_thread(tmp_path, record)).ensure(LayerSpec(record, 0.18))
    forked = await MapCache(tmp_path / "b", build=LayerBuilder(kept(record))).ensure(LayerSpec(record, 0.18))
    names = {file.name for file in here.iterdir()}
    assert len(names) == 5
    assert {file.name: file.read_bytes() for file in forked.iterdir()} == {n: (here / n).read_bytes() for n in names}


def scaled(map_id: str, values: bytes) -> GivenMap:
    """Return a mask of two cells of 1 m, beside and on the house, with these gray values."""
    yaml = b"image: a.pgm\nresolution: 1.0\norigin: [-2.0, -2.5, 0.0]\nmode: scale\nfree_thresh: 0.001\n"
    return house(map_id, image=b"P5\n2 1\n255\n" + values, yaml=yaml + b"occupied_thresh: 0.999\n")


async def test_masks_are_applied_in_the_requested_versions(tmp_path):
    record, kept_out, slow = house(image=pgm(40, 30)), scaled("kept", b"\x00\x00"), scaled("slow", b"\xff\x80")
    store = kept(record)
    for given in (kept_out, slow, scaled("kept", b"\xff\xff")):
        put_map(store, given)
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(store))
    masks = {"keepout_filter": kept_out, "speed_filter": slow}
    layers = open_layers(await cache.ensure(LayerSpec(record, 0.18, masks)))
    keepout, speed = (load_map(mask.yaml, mask.image) for mask in (kept_out, slow))
    expected = build_layers(layers.grid, robot_radius=0.18, keepout=keepout, speed=speed)
    np.testing.assert_array_equal(layers.costmap.data, expected.costmap.data)
    np.testing.assert_array_equal(layers.keepout.data, expected.keepout.data)
    np.testing.assert_array_equal(layers.speed.data, expected.speed.data)
    np.testing.assert_array_equal(layers.to_lethal, expected.to_lethal)
    assert layers.costmap.data.max() == 254
    assert 0 < layers.speed.data.max() < 100
    bare = open_layers(await cache.ensure(LayerSpec(record, 0.18)))
    assert bare.costmap.data.max() == 0


async def test_layers_have_the_costs_that_are_requested(tmp_path):
    cells = np.full((30, 40), 254, np.uint8)
    cells[:, 20] = 51  # occupancy 0.8
    yaml = b"image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nmode: scale\noccupied_thresh: 0.9\nfree_thresh: 0.1\n"
    record = house(image=b"P5\n40 30\n255\n" + cells.tobytes(), yaml=yaml)
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(kept(record)))
    built = {}
    for costs in (CostParameters(), CostParameters(inflation_radius=0.3), CostParameters(lethal_cost_threshold=100)):
        layers = open_layers(await cache.ensure(LayerSpec(record, 0.18, costs=costs)))
        built[costs] = layers.costmap.data
        assert np.array_equal(built[costs], recosted(layers, 0.18, costs).data)
    assert [int((data > 0).sum()) for data in built.values()] == [30 * 23, 30 * 13, 0]


async def test_octomap_obstacles_at_robot_height_are_on_the_layers(tmp_path):
    octomap = (ROOT / "docs" / "examples" / "table.bt").read_bytes()
    image = b"P5\n80 60\n255\n" + bytes([254] * 4800)
    room = house(image=image, yaml=YAML.replace(b"[-1.0, -2.0, 0.0]", b"[0.0, 0.0, 0.0]"), octomap=octomap)
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(kept(room)))
    costs = {}
    for heights in ((None, 0.42), (0.05, 1.2)):
        layers = open_layers(await cache.ensure(LayerSpec(room, 0.18, heights=heights)))
        costs[heights] = layers.costmap.data[layers.grid.info.cell_of(2.0, 1.5)]
    assert costs == {(None, 0.42): 0, (0.05, 1.2): 254}
    flat = MapCache(tmp_path / "flat", build=LayerBuilder(kept(house())))
    assert open_layers(await flat.ensure(LayerSpec(house(), 0.18, heights=(None, 1.2)))).keepout is None


async def test_missing_or_gridless_mask_is_refused(tmp_path):
    store = kept(house())
    put_map(store, house("cave", image=None, octomap=b"..."))
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(store))
    for mask, why in ((house("gone"), "is not a published map"), (house("cave"), "has an octomap and no grid")):
        version = found_map(store, "cave").version if mask.id == "cave" else mask.version
        with pytest.raises(InvalidParameter, match=f"speed_filter: the mask '{mask.id}' {why}"):
            await cache.ensure(LayerSpec(house(), 0.18, {"speed_filter": MapVersion(mask.id, version)}))
    assert list((tmp_path / "shm").iterdir()) == []


async def test_error_of_the_forked_process_keeps_its_type(tmp_path):
    record = house(image=b"no image")
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(kept(record)))
    with pytest.raises(InvalidMap):
        await cache.ensure(LayerSpec(record, 0.18))
    assert list((tmp_path / "shm").iterdir()) == []


async def test_older_map_version_is_still_built(tmp_path):
    old, new = (house(image=pgm(width, 4)) for width in (5, 6))
    store = kept(old)
    put_map(store, new)
    folder = await MapCache(tmp_path / "shm", build=LayerBuilder(store)).ensure(LayerSpec(old, 0.18))
    assert open_layers(folder).grid.info.width == 5


async def test_missing_or_gridless_map_is_refused(tmp_path):
    cave = house("cave", image=None, octomap=b"...")
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(kept(cave)))
    with pytest.raises(InvalidMap, match="no grid"):
        await cache.ensure(LayerSpec(cave, 0.18))
    with pytest.raises(NotFound, match="house"):
        await cache.ensure(LayerSpec(house(), 0.18))


async def test_cached_layers_are_used_while_the_store_is_unavailable(tmp_path, monkeypatch):
    store = kept(house())
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(store))
    folder = await cache.ensure(LayerSpec(house(), 0.18))
    cache.release(folder)

    def away(*_arguments, **_options):
        raise Unavailable("the store is away")

    monkeypatch.setattr(store, "open_map", away)
    assert await cache.ensure(LayerSpec(house(), 0.18)) == folder
    with pytest.raises(Unavailable, match="away"):
        await cache.ensure(LayerSpec(house(), 0.35))


async def test_layers_requested_at_once_are_built_once(cache, building):
    building.go.clear()
    waiting = [asyncio.create_task(cache.ensure(LayerSpec(house(), 0.18))) for _ in range(10)]
    await asyncio.sleep(0)
    building.go.set()
    assert len(set(await asyncio.gather(*waiting))) == 1
    assert building.built == ["house"]


async def test_each_version_and_radius_has_its_own_layers(cache):
    one, two = house(), house(image=pgm(value=0))
    asked = [(one, 0.18), (one, 0.2), (two, 0.18)]
    assert len({await cache.ensure(LayerSpec(*each)) for each in asked}) == 3


async def test_layers_appear_only_when_complete(cache, building):
    building.go.clear()
    waiting = asyncio.create_task(cache.ensure(LayerSpec(house(), 0.18)))
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert [folder.name for folder in cache._root.glob("map-*")] == []
    building.go.set()
    assert (await waiting / "layers").exists()


async def test_failure_reaches_all_waiters_and_the_next_request_retries(cache, building):
    building.failures = [InvalidMap("no map")]
    results = await asyncio.gather(*(cache.ensure(LayerSpec(house(), 0.18)) for _ in range(3)), return_exceptions=True)
    assert [type(each) for each in results] == [InvalidMap] * 3
    assert folders(cache) == []
    await cache.ensure(LayerSpec(house(), 0.18))
    assert building.built == ["house"]


async def test_cancelled_waiter_does_not_stop_the_others(cache, building):
    building.go.clear()
    first, second = (asyncio.create_task(cache.ensure(LayerSpec(house(), 0.18))) for _ in range(2))
    await asyncio.sleep(0)
    first.cancel()
    await asyncio.sleep(0)
    building.go.set()
    assert (await second).exists()


async def test_used_layers_and_the_last_released_stay(cache):
    used = await cache.ensure(LayerSpec(house("used"), 0.18))
    for name in "abc":
        cache.release(await cache.ensure(LayerSpec(house(name), 0.18)))
    assert folders(cache) == ["map-b", "map-c", "map-used"]
    assert used.exists()


async def test_layers_are_removed_after_the_last_release(tmp_path, building):
    cache = MapCache(tmp_path / "shm", build=building, spare=0)
    one = await cache.ensure(LayerSpec(house(), 0.18))
    await cache.ensure(LayerSpec(house(), 0.18))
    cache.release(one)
    assert one.exists()
    cache.release(one)
    assert not one.exists()
    with pytest.raises(ValueError, match="more often"):
        cache.release(one)


async def test_unused_layers_are_removed_if_the_disk_is_full(cache, building):
    cache.release(await cache.ensure(LayerSpec(house("a"), 0.18)))
    building.failures = [Unavailable("disk full")]
    await cache.ensure(LayerSpec(house("b"), 0.18))
    assert folders(cache) == ["map-b"]


async def test_full_disk_is_reported(cache, building):
    building.failures = [Unavailable("disk full")]
    with pytest.raises(Unavailable, match="disk full"):
        await cache.ensure(LayerSpec(house(), 0.18))


async def test_full_disk_error_names_size_and_folder(tmp_path):
    record = house(image=pgm(200, 200))
    cache = MapCache(tmp_path / "shm", build=build_in_thread(tmp_path, record))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        with pytest.raises(Unavailable, match=r"MB of map layers cannot be written to .*shm"):
            await cache.ensure(LayerSpec(record, 0.18))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert list((tmp_path / "shm").iterdir()) == []


@pytest.mark.parametrize("radius", [-0.1, math.nan, math.inf])
async def test_invalid_radius_is_refused(cache, radius):
    with pytest.raises(InvalidParameter, match="radius"):
        await cache.ensure(LayerSpec(house(), radius))


async def test_map_name_cannot_leave_the_folder(cache):
    record = MapVersion("../../etc", "../v")
    folder = await cache.ensure(LayerSpec(record, 0.18))
    assert folder.resolve().parent == cache._root.resolve()


async def test_remove_all_leaves_no_files(cache, tmp_path):
    await cache.ensure(LayerSpec(house(), 0.18))
    cache.remove_all()
    assert list(tmp_path.iterdir()) == []


async def test_repeated_index_requests_build_it_once(indexed, indexing):
    folder = await indexed.ensure(LayerSpec(house(), 0.18))
    await asyncio.gather(*(indexed.prepare(folder, "p") for _ in range(10)))
    await indexed.prepare(folder, "p")
    assert (folder / "p.index").read_text() == "made"
    assert indexing.made == ["p"]


async def test_index_build_survives_cancellation_and_holds_its_layers(indexed, indexing):
    folder = await indexed.ensure(LayerSpec(house(), 0.18))
    indexing.go.clear()
    waiting = asyncio.create_task(indexed.prepare(folder, "p"))
    await asyncio.sleep(0)
    waiting.cancel()
    await asyncio.sleep(0)
    indexed.release(folder)
    assert folder.exists()
    indexing.go.set()
    async with patience(10):
        while folder.exists():
            await asyncio.sleep(0)


async def test_index_a_planner_cannot_prepare_is_tried_once(indexed, indexing):
    folder = await indexed.ensure(LayerSpec(house(), 0.18))
    indexing.failures = [InvalidPlanner("too cluttered")]
    for _ in range(3):
        with pytest.raises(InvalidPlanner, match="cluttered"):
            await indexed.prepare(folder, "p")
    assert indexing.made == ["p"]


async def test_index_that_failed_for_other_reasons_is_retried(indexed, indexing):
    folder = await indexed.ensure(LayerSpec(house(), 0.18))
    indexing.failures = [Unavailable("full")]
    with pytest.raises(Unavailable):
        await indexed.prepare(folder, "p")
    await indexed.prepare(folder, "p")
    assert (folder / "p.index").exists()


async def test_unused_layers_are_removed_to_fit_an_index(tmp_path, building, indexing):
    cache = MapCache(tmp_path / "shm", build=building, index=indexing, spare=2)
    cache.release(await cache.ensure(LayerSpec(house("a"), 0.18)))
    folder = await cache.ensure(LayerSpec(house("b"), 0.18))
    indexing.failures = [Unavailable("full")]
    await cache.prepare(folder, "p")
    assert folders(cache) == ["map-b"]


async def test_planner_name_cannot_leave_the_folder(indexed, indexing):
    folder = await indexed.ensure(LayerSpec(house(), 0.18))
    indexing.failures = [NotFound("index", "../../p")]
    with pytest.raises(NotFound):
        await indexed.prepare(folder, "../../p")


async def test_forked_process_builds_the_planners_index(tmp_path):
    image = b"P5\n60 50\n255\n" + bytes(0 if (i // 60) % 7 == 3 and i % 60 % 11 else 254 for i in range(3000))
    record = house(image=image)
    cache = MapCache(tmp_path / "shm", build=build_in_thread(tmp_path, record))
    folder = await cache.ensure(LayerSpec(record, 0.05))
    await cache.prepare(folder, "hub_labels")
    costmap = open_layers(folder).costmap
    made = HubLabels().prepare(costmap)
    found = HubLabels().prepare(replace(costmap, indexes=SharedIndexes(folder)))
    assert not found.words.flags.owndata
    np.testing.assert_array_equal(found.words, made.words)
    with pytest.raises(NotFound, match="known: hub_labels"):
        await cache.prepare(folder, "dijkstra")
    assert {file.name for file in folder.iterdir() if "index" in file.name} == {"hub_labels.index"}


async def test_too_cluttered_map_is_refused_with_alternative_planners(tmp_path):
    free = np.random.default_rng(0).random((1024, 1024)) >= 0.2
    record = house(image=b"P5\n1024 1024\n255\n" + np.where(free, 254, 0).astype(np.uint8).tobytes())
    cache = MapCache(tmp_path / "shm", build=build_in_thread(tmp_path, record))
    folder = await cache.ensure(LayerSpec(record, 0.01))
    with pytest.raises(InvalidPlanner, match="jps or dijkstra"):
        await cache.prepare(folder, "hub_labels")
    assert not list(folder.glob("*.index"))


async def test_a_comparison_that_failed_is_repeated(cache: MapCache, monkeypatch: pytest.MonkeyPatch) -> None:
    outcomes: list[Exception | None] = [Unavailable("no complete map layers"), None]

    def compare(_before: Path, _after: Path) -> None:
        outcome = outcomes.pop(0)
        if outcome is not None:
            raise outcome

    monkeypatch.setattr(map_cache, "changed_cells", compare)
    with pytest.raises(Unavailable):
        await cache.changes(Path("a"), Path("b"))
    assert await cache.changes(Path("a"), Path("b")) is None
    assert await cache.changes(Path("a"), Path("b")) is None
    assert outcomes == []
