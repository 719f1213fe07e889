"""The base under test is ours: every `bench` of these tests gets it."""

import pytest
from controller import CrawlingBase


@pytest.fixture
def controller():
    return CrawlingBase
