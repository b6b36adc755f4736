import pytest
from msgspec.structs import replace

from engine.runtimes.docker import container as docker_limits
from tests.support.engine.launches import Reports


@pytest.fixture
def launch(tmp_path):
    return Reports(tmp_path).launch


def test_size_sets_cpu_quota_and_cpu_set(launch):
    limits = docker_limits.launch_limits(launch(cpus=(1, 3)))
    assert (limits["cpu_quota"] / limits["cpu_period"], limits["cpuset_cpus"]) == (2.0, "1,3")


def test_more_cores_get_more_cpu_shares_and_memory_without_swap(launch):
    one, two = (docker_limits.launch_limits(launch(cpus=cpus)) for cpus in ((0,), (0, 1)))
    assert two["cpu_shares"] == 2 * one["cpu_shares"] > docker_limits.spare_limits()["cpu_shares"]
    assert two["mem_limit"] > one["mem_limit"] > docker_limits.spare_limits()["mem_limit"]
    assert all(limits["memswap_limit"] == limits["mem_limit"] for limits in (one, two))


def test_the_smallest_size_is_accepted_by_the_kernel(launch):
    tiny = launch(cpus=(0,))
    limits = docker_limits.launch_limits(replace(tiny, spec=replace(tiny.spec, cores=1e-6)))
    assert limits["cpu_quota"] >= 1000
    assert limits["cpu_shares"] >= 2
