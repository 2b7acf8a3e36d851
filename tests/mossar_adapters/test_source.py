"""Names of what sources yield that have changed."""

import pytest

from mossar_adapters import source


@pytest.mark.parametrize(("former", "now"), [("Left", source.Departure), ("Came", source.Occupant)])
def test_a_former_name_works_for_one_release_with_a_warning(former, now):
    with pytest.warns(DeprecationWarning, match=f"is called {now.__name__} now"):
        assert getattr(source, former) is now
    with pytest.raises(AttributeError, match="Gone"):
        _ = source.Gone
