"""Test of the reuse of freed memory: repeated images cause no new pages."""

import platform
import resource

import numpy as np
import pytest

from eyehand.perception.segmentation.freed_memory import reuse_freed_memory


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only the GNU allocator is set up")
def test_repeated_images_cause_no_page_faults():
    reuse_freed_memory()

    def take_images():
        images = [np.ones((480, 640), np.float32) for _ in range(6)]
        return sum(float(image[0, 0]) for image in images)

    take_images()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(10):
        take_images()
    faults = resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
    # 10 x 6 images have 18,000 pages.
    assert faults < 2000
