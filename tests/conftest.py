from hypothesis import settings

# A deadline would measure how busy the machine is.
settings.register_profile("vibrissa", deadline=None)
settings.load_profile("vibrissa")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)
