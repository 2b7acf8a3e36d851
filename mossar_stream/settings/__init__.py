"""Settings: the choices of users, by themselves or by levels and presets."""

from mossar_stream.settings.settings import LEVEL_NAMES as LEVEL_NAMES
from mossar_stream.settings.settings import SETTING_CHOICES as SETTING_CHOICES
from mossar_stream.settings.settings import SETTING_LIMITS as SETTING_LIMITS
from mossar_stream.settings.settings import SETTING_METAS as SETTING_METAS
from mossar_stream.settings.settings import Center as Center
from mossar_stream.settings.settings import Features as Features
from mossar_stream.settings.settings import KernelForm as KernelForm
from mossar_stream.settings.settings import LevelName as LevelName
from mossar_stream.settings.settings import Location as Location
from mossar_stream.settings.settings import RangePolicy as RangePolicy
from mossar_stream.settings.settings import ResolvedSettings as ResolvedSettings
from mossar_stream.settings.settings import Rests as Rests
from mossar_stream.settings.settings import Settings as Settings
from mossar_stream.settings.settings import SimilarityName as SimilarityName
from mossar_stream.settings.settings import Smoothing as Smoothing
from mossar_stream.settings.settings import Up as Up
from mossar_stream.settings.settings import VarianceFloor as VarianceFloor
from mossar_stream.settings.settings import settings_or_default as settings_or_default
