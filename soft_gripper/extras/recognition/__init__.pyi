"""Recognition of the object that is held."""

from .object_classifier import ObjectClassifier as ObjectClassifier
from .object_classifier import grasp_features as grasp_features
from .object_classifier import load_object_classifier as load_object_classifier
from .object_classifier import save_object_classifier as save_object_classifier
from .object_classifier import train_object_classifier as train_object_classifier
from .recognizer import ObjectRecognizer as ObjectRecognizer
