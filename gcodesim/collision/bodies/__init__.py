"""The bodies of a scene on the device: regions, trees and reach."""
